//! Where rows come from.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{ErrorKind, Read};
use std::net::{IpAddr, SocketAddr, UdpSocket};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

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
    /// Rows that the caller gives, some at each poll.
    Given(VecDeque<Vec<StreamRow>>),
    /// A text file that may grow; it has ended when it was not written to for so long.
    Tail {
        file: Box<TailedFile>,
        /// Its place.
        path: PathBuf,
        /// Time without a change after which it has ended; none for never.
        wait: Option<Duration>,
        /// When rows were last read.
        last: Instant,
        /// Why it cannot be read at present.
        trouble: Option<String>,
    },
    /// Lines by UDP.
    Lines { socket: Socket, format: LineFormat, text: Box<TextDecoder>, json: JsonDecoder },
    /// MAVLink packets by UDP.
    Mavlink { socket: Socket, decoder: Box<MavlinkDecoder> },
    /// MAVLink packets of a telemetry log.
    Log {
        file: File,
        /// Its place.
        path: PathBuf,
        decoder: Box<MavlinkDecoder>,
    },
}

impl Source {
    /// A text file as it grows.
    pub fn tail(path: &Path, wait: Option<Duration>) -> Result<Self, String> {
        let file = TailedFile::open(path).map_err(|error| error.to_string())?;
        Ok(Self::Tail { file: file.into(), path: path.to_owned(), wait, last: Instant::now(), trouble: None })
    }

    /// Lines by UDP at `address`, from the senders `from` alone where there are some.
    pub fn lines(address: &str, from: &[IpAddr], format: LineFormat) -> Result<Self, String> {
        let (text, json) = (TextDecoder::new("stream").into(), JsonDecoder::default());
        Ok(Self::Lines { socket: Socket::listen(address, from)?, format, text, json })
    }

    /// MAVLink packets by UDP at `address`, from the senders `from` alone where there are some.
    pub fn mavlink(address: &str, from: &[IpAddr]) -> Result<Self, String> {
        Ok(Self::Mavlink { socket: Socket::listen(address, from)?, decoder: Box::default() })
    }

    /// MAVLink packets of a telemetry log.
    ///
    /// # Errors
    /// One line when it cannot be opened, or is a pipe that may never be written.
    pub fn log(path: &Path) -> Result<Self, String> {
        let about = path.metadata().map_err(|error| format!("{}: {error}", path.display()))?;
        if !about.is_file() {
            return Err(format!("{} is a pipe, a device or a folder: name a telemetry log", path.display()));
        }
        let file = File::open(path).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(Self::Log { file, path: path.to_owned(), decoder: Box::default() })
    }

    /// Whether its rows come in order and once: those of a recording that was read as a whole.
    pub(super) fn is_trusted(&self) -> bool {
        matches!(self, Self::Replay(_))
    }

    /// Whether rows come as they are measured, so that silence is a fault.
    pub(super) fn is_live(&self) -> bool {
        matches!(self, Self::Tail { .. } | Self::Lines { .. } | Self::Mavlink { .. })
    }

    /// How often a growing file was written anew.
    pub(super) fn files_begun(&self) -> usize {
        match self {
            Self::Tail { file, .. } => file.restarts,
            _ => 0,
        }
    }

    /// Place of the socket, where there is one.
    pub fn address(&self) -> Option<SocketAddr> {
        match self {
            Self::Lines { socket, .. } | Self::Mavlink { socket, .. } => socket.socket.local_addr().ok(),
            _ => None,
        }
    }

    /// Adds the rows that came.
    pub fn poll(&mut self, rows: &mut Vec<StreamRow>) -> Result<Polled, String> {
        match self {
            Self::Replay(replay) => Ok(if replay.poll(rows) { Polled::Rows } else { Polled::Ended }),
            Self::Given(pieces) => Ok(pieces.pop_front().map_or(Polled::Ended, |piece| {
                rows.extend(piece);
                Polled::Rows
            })),
            Self::Tail { file, path, wait, last, trouble } => {
                // One that was replaced may not be there yet, or not be readable yet.
                let read = file.poll(rows);
                *trouble = read.as_ref().err().map(ToString::to_string);
                if read.is_ok_and(|has_rows| has_rows) {
                    *last = Instant::now();
                    return Ok(Polled::Rows);
                }
                if !wait.is_some_and(|wait| is_unchanged_for(path, *last, wait)) {
                    return Ok(Polled::Nothing);
                }
                file.finish(rows);
                Ok(Polled::Ended)
            }
            Self::Lines { socket, format, text, json } => socket.receive(|datagram| {
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
            Self::Mavlink { socket, decoder } => socket.receive(|datagram| {
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
        let (own, foreign) = match self {
            Self::Replay(_) | Self::Given(_) => (None, 0),
            Self::Tail { file, trouble, .. } => {
                let (refused, restarts) = (file.refused_bytes(), file.restarts);
                let line = || format!("{refused} bytes of the file are not rows; it was restarted {restarts} times");
                let trouble = trouble.iter().map(|trouble| format!("{trouble}; the file is tried again"));
                let lines = (refused > 0 || restarts > 0).then(line).into_iter().chain(trouble);
                (Some(lines.collect::<Vec<_>>().join("; ")).filter(|line| !line.is_empty()), 0)
            }
            Self::Lines { socket, text, json, .. } => {
                let (lines, bytes) = (json.refused, text.refused_bytes);
                let line = || format!("{lines} lines of JSON and {bytes} bytes of text could not be understood");
                ((bytes > 0 || lines > 0).then(line), socket.foreign)
            }
            Self::Mavlink { socket, decoder } => (losses_of(decoder), socket.foreign),
            Self::Log { decoder, .. } => (losses_of(decoder), 0),
        };
        let foreign = (foreign > 0).then(|| format!("{foreign} packets from other addresses ignored"));
        let lines: Vec<String> = own.into_iter().chain(foreign).collect();
        (!lines.is_empty()).then(|| lines.join("; "))
    }
}

/// What of MAVLink packets is missing.
fn losses_of(decoder: &MavlinkDecoder) -> Option<String> {
    let MavlinkDecoder { packets, lost, refused_bytes, .. } = decoder;
    let line =
        || format!("{packets} packets read, {lost} lost by sequence number, {refused_bytes} bytes outside packets");
    (*lost > 0 || *packets == 0).then(line)
}

/// A socket that does not wait.
#[derive(Debug)]
pub struct Socket {
    socket: UdpSocket,
    /// The senders whose packets are taken; empty for all.
    from: Vec<IpAddr>,
    /// Packets of others.
    foreign: u64,
}

impl Socket {
    fn listen(address: &str, from: &[IpAddr]) -> Result<Self, String> {
        let named = |error: std::io::Error| {
            format!("{address}: {error}: give an address of this computer and a port, such as 127.0.0.1:14550")
        };
        let socket = UdpSocket::bind(address).map_err(named)?;
        socket.set_nonblocking(true).map_err(named)?;
        Ok(Self { socket, from: from.iter().map(IpAddr::to_canonical).collect(), foreign: 0 })
    }

    /// Takes the datagrams that wait.
    fn receive(&mut self, mut take: impl FnMut(&[u8])) -> Result<Polled, String> {
        let mut datagram = vec![0; DATAGRAM];
        for count in 0..DATAGRAMS {
            match self.socket.recv_from(&mut datagram) {
                Ok((length, sender)) if self.is_heard(sender) => take(&datagram[..length]),
                Ok(_) => self.foreign += 1,
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

    fn is_heard(&self, sender: SocketAddr) -> bool {
        self.from.is_empty() || self.from.contains(&sender.ip().to_canonical())
    }
}

/// Whether a file was not written to for so long; one that is gone or whose time lies in the future, since it was last read.
fn is_unchanged_for(path: &Path, last: Instant, wait: Duration) -> bool {
    let changed = path.metadata().and_then(|about| about.modified()).ok();
    let age = changed.and_then(|changed| SystemTime::now().duration_since(changed).ok());
    age.unwrap_or_else(|| last.elapsed()) > wait
}
