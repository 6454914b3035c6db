//! Where rows come from.

use std::fs::File;
use std::io::{ErrorKind, Read};
use std::net::UdpSocket;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use doublet_core::load::stream::{JsonDecoder, MavlinkDecoder, StreamRow, TailedFile, TextDecoder};

use super::replay::Replay;

/// Largest datagram.
const DATAGRAM: usize = 65_536;
/// Datagrams taken at once.
const DATAGRAMS: usize = 256;
/// Bytes of a telemetry log read at once.
const PIECE: usize = 16 * 1024;

/// What the lines of a stream are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LineFormat {
    /// JSON where a line begins with a brace, otherwise values with separators.
    #[default]
    Any,
    /// Objects of JSON.
    Json,
    /// Values with separators, as in a text recording.
    Text,
}

/// Whether there may be more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Polled {
    /// Rows came.
    Rows,
    /// Nothing now.
    Nothing,
    /// Nothing any more.
    Ended,
}

/// Where rows come from.
#[derive(Debug)]
pub enum Source {
    /// A recording flown again.
    Replay(Replay),
    /// A text file that may grow; it has ended when it was not written to for so long.
    Tail {
        /// File.
        file: Box<TailedFile>,
        /// Its place.
        path: PathBuf,
        /// Time without a change after which it has ended; none for never.
        wait: Option<Duration>,
    },
    /// Lines by UDP.
    Lines {
        /// Socket.
        socket: UdpSocket,
        /// What the lines are.
        format: LineFormat,
        /// Decoder of text.
        text: Box<TextDecoder>,
        /// Decoder of JSON.
        json: JsonDecoder,
    },
    /// MAVLink packets by UDP.
    Mavlink {
        /// Socket.
        socket: UdpSocket,
        /// Decoder.
        decoder: Box<MavlinkDecoder>,
    },
    /// MAVLink packets of a telemetry log.
    Log {
        /// File.
        file: File,
        /// Its place.
        path: PathBuf,
        /// Decoder.
        decoder: Box<MavlinkDecoder>,
    },
}

impl Source {
    /// A text file as it grows.
    ///
    /// # Errors
    /// One line when it cannot be opened.
    pub fn tail(path: &Path, wait: Option<Duration>) -> Result<Self, String> {
        let file = TailedFile::open(path).map_err(|error| error.to_string())?;
        Ok(Self::Tail { file: file.into(), path: path.to_owned(), wait })
    }

    /// Lines by UDP at `address`.
    ///
    /// # Errors
    /// One line when nothing can listen there.
    pub fn lines(address: &str, format: LineFormat) -> Result<Self, String> {
        let (text, json) = (TextDecoder::new("stream").into(), JsonDecoder::default());
        Ok(Self::Lines { socket: listen(address)?, format, text, json })
    }

    /// MAVLink packets by UDP at `address`.
    ///
    /// # Errors
    /// One line when nothing can listen there.
    pub fn mavlink(address: &str) -> Result<Self, String> {
        Ok(Self::Mavlink { socket: listen(address)?, decoder: Box::default() })
    }

    /// MAVLink packets of a telemetry log.
    ///
    /// # Errors
    /// One line when it cannot be opened.
    pub fn log(path: &Path) -> Result<Self, String> {
        let file = File::open(path).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(Self::Log { file, path: path.to_owned(), decoder: Box::default() })
    }

    /// Place of the socket, where there is one.
    pub fn address(&self) -> Option<std::net::SocketAddr> {
        match self {
            Self::Lines { socket, .. } | Self::Mavlink { socket, .. } => socket.local_addr().ok(),
            _ => None,
        }
    }

    /// Adds the rows that came.
    ///
    /// # Errors
    /// One line when the source cannot be read.
    pub fn poll(&mut self, rows: &mut Vec<StreamRow>) -> Result<Polled, String> {
        match self {
            Self::Replay(replay) => Ok(if replay.poll(rows) { Polled::Rows } else { Polled::Ended }),
            Self::Tail { file, path, wait } => {
                if file.poll(rows).map_err(|error| error.to_string())? {
                    return Ok(Polled::Rows);
                }
                if !wait.is_some_and(|wait| is_unchanged_for(path, wait)) {
                    return Ok(Polled::Nothing);
                }
                file.finish(rows);
                Ok(Polled::Ended)
            }
            Self::Lines { socket, format, text, json } => receive(socket, |datagram| {
                let is_json = match format {
                    LineFormat::Json => true,
                    LineFormat::Text => false,
                    LineFormat::Any => datagram.trim_ascii_start().first() == Some(&b'{'),
                };
                if is_json {
                    let lines = String::from_utf8_lossy(datagram);
                    rows.extend(
                        lines.lines().filter(|line| !line.trim().is_empty()).filter_map(|line| json.decode(line)),
                    );
                } else {
                    text.push(datagram, rows);
                    if datagram.last() != Some(&b'\n') {
                        text.push(b"\n", rows);
                    }
                }
            }),
            Self::Mavlink { socket, decoder } => receive(socket, |datagram| {
                decoder.push(datagram, rows);
                decoder.end_of_datagram(rows);
            }),
            Self::Log { file, path, decoder } => {
                let mut piece = vec![0; PIECE];
                let read = file.read(&mut piece).map_err(|error| format!("{}: {error}", path.display()))?;
                decoder.push(&piece[..read], rows);
                if read == 0 {
                    decoder.end_of_datagram(rows);
                }
                Ok(if read > 0 { Polled::Rows } else { Polled::Ended })
            }
        }
    }

    /// What of the stream could not be understood or is missing by its own count, in one line; none where all is well.
    pub fn losses(&self) -> Option<String> {
        match self {
            Self::Replay(_) => None,
            Self::Tail { file, .. } => {
                let (refused, restarts) = (file.refused_bytes(), file.restarts);
                (refused > 0 || restarts > 0)
                    .then(|| format!("{refused} bytes of the file are no rows; it was begun anew {restarts} times"))
            }
            Self::Lines { text, json, .. } => (text.refused_bytes > 0 || json.refused > 0).then(|| {
                format!(
                    "{} lines of JSON and {} bytes of text could not be understood",
                    json.refused, text.refused_bytes
                )
            }),
            Self::Mavlink { decoder, .. } | Self::Log { decoder, .. } => (decoder.lost > 0 || decoder.packets == 0)
                .then(|| {
                    let MavlinkDecoder { packets, lost, refused_bytes, .. } = &**decoder;
                    format!(
                        "{packets} packets understood, {lost} missing by their numbers, {refused_bytes} bytes were none"
                    )
                }),
        }
    }
}

/// A socket that does not wait.
fn listen(address: &str) -> Result<UdpSocket, String> {
    let named = |error: std::io::Error| {
        format!("{address}: {error}: give an address of this computer and a port, such as 0.0.0.0:14550")
    };
    let socket = UdpSocket::bind(address).map_err(named)?;
    socket.set_nonblocking(true).map_err(named)?;
    Ok(socket)
}

/// Takes the datagrams that wait.
fn receive(socket: &UdpSocket, mut take: impl FnMut(&[u8])) -> Result<Polled, String> {
    let mut datagram = vec![0; DATAGRAM];
    for count in 0..DATAGRAMS {
        match socket.recv(&mut datagram) {
            Ok(length) => take(&datagram[..length]),
            Err(error) if error.kind() == ErrorKind::WouldBlock => {
                return Ok(if count > 0 { Polled::Rows } else { Polled::Nothing });
            }
            // A sender that is gone says so on some systems; the next may come.
            Err(error) if matches!(error.kind(), ErrorKind::ConnectionReset | ErrorKind::Interrupted) => {}
            Err(error) => return Err(format!("the socket cannot be read: {error}")),
        }
    }
    Ok(Polled::Rows)
}

/// Whether a file was not written to for so long.
fn is_unchanged_for(path: &Path, wait: Duration) -> bool {
    let changed = path.metadata().and_then(|about| about.modified());
    changed.is_ok_and(|changed| SystemTime::now().duration_since(changed).is_ok_and(|age| age > wait))
}
