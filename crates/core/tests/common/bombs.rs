//! Small files that take much memory when they are unpacked, one of each format.

use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;

/// Bytes that one compressed part unpacks to, and how many parts a file has.
const PART: usize = 8_000_000;
const PARTS: usize = 20;

/// Name and content of each file.
pub fn bombs() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("table.csv", table()),
        ("topics.ulg", ulog()),
        ("packets.bin", dataflash()),
        ("lines.log", dataflash_text()),
        ("segment.tdms", tdms()),
        ("chunks.mcap", mcap_chunks()),
        ("columns.mcap", mcap_columns()),
        ("blocks.mf4", mdf4_blocks()),
        ("shared.mf4", mdf4_shared_channels()),
        ("pages.parquet", parquet()),
    ]
}

/// Beginnings of files that are read as a whole.
pub const HEADS: [(&str, &[u8]); 8] = [
    ("whole.csv", b"time,p\n0,1\n1,2\n"),
    ("whole.ulg", b"ULog\x01\x12\x35\x01\0\0\0\0\0\0\0\0"),
    ("whole.bin", b"\xa3\x95\x80"),
    ("whole.tdms", b"TDSm"),
    ("whole.mcap", b"\x89MCAP0\r\n"),
    ("whole.mf4", b"MDF     4.10    "),
    ("whole.parquet", b"PAR1"),
    ("whole.mat", b"MATLAB 5.0 MAT-file"),
];

fn table() -> Vec<u8> {
    [b"time,p,q,r\n".to_vec(), b"1,1,1,1\n".repeat(1_000_000)].concat()
}

fn ulog() -> Vec<u8> {
    let message = |kind: u8, body: &[u8]| [&(body.len() as u16).to_le_bytes()[..], &[kind], body].concat();
    let data = message(b'D', &[&[1, 0][..], &[7; 4000]].concat());
    [
        b"ULog\x01\x12\x35\x01\0\0\0\0\0\0\0\0".to_vec(),
        message(b'F', b"f:uint8_t[4000] x;"),
        message(b'A', b"\0\x01\0f"),
        data.repeat(1000),
    ]
    .concat()
}

/// A description of messages `name`, whose letters stand for one byte each.
fn description(of: u8, length: u8, name: &str, format: &str, labels: &str) -> Vec<u8> {
    let mut bytes = vec![0xa3, 0x95, 0x80, of, length];
    for (text, room) in [(name, 4), (format, 16), (labels, 64)] {
        let mut field = text.as_bytes().to_vec();
        field.resize(room, 0);
        bytes.extend(field);
    }
    bytes
}

fn dataflash() -> Vec<u8> {
    let format = "B".repeat(16);
    let message = [&[0xa3, 0x95, 1][..], &[7; 16]].concat();
    [
        description(0x80, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns"),
        description(1, 19, "IMU", &format, ""),
        message.repeat(300_000),
    ]
    .concat()
}

fn dataflash_text() -> Vec<u8> {
    let head =
        "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\nFMT, 1, 11, IMU, BBBBBBBB, a,b,c,d,e,f,g,h\n";
    [head.as_bytes().to_vec(), b"IMU,1,1,1,1,1,1,1,1\n".repeat(400_000)].concat()
}

fn tdms() -> Vec<u8> {
    const SAMPLES: u32 = 4_000_000;
    let path = b"/'group'/'channel'";
    let index = [20_u32.to_le_bytes(), 5_u32.to_le_bytes(), 1_u32.to_le_bytes()].concat();
    let object = [
        &1_u32.to_le_bytes()[..],
        &(path.len() as u32).to_le_bytes(),
        path,
        &index,
        &u64::from(SAMPLES).to_le_bytes(),
        &0_u32.to_le_bytes(),
    ]
    .concat();
    let raw = vec![7_u8; SAMPLES as usize];
    // Contents: description, new objects, raw data.
    let lead_in = [
        &b"TDSm"[..],
        &0b1110_u32.to_le_bytes(),
        &4713_u32.to_le_bytes(),
        &((object.len() + raw.len()) as u64).to_le_bytes(),
        &(object.len() as u64).to_le_bytes(),
    ]
    .concat();
    [lead_in, object, raw].concat()
}

fn mcap_record(kind: u8, body: &[u8]) -> Vec<u8> {
    [&[kind][..], &(body.len() as u64).to_le_bytes(), body].concat()
}

fn mcap_text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat()
}

/// A topic of JSON.
fn mcap_topic() -> Vec<u8> {
    let channel = [&[1, 0, 0, 0][..], &mcap_text("/imu"), &mcap_text("json"), &0_u32.to_le_bytes()].concat();
    mcap_record(4, &channel)
}

fn mcap_message(text: &str) -> Vec<u8> {
    mcap_record(5, &[&[1, 0][..], &[0; 4], &[0; 16], text.as_bytes()].concat())
}

/// Compressed chunks.
fn mcap_chunks() -> Vec<u8> {
    let mut packed = lz4_flex::frame::FrameEncoder::new(Vec::new());
    packed.write_all(&vec![0; PART]).unwrap();
    let packed = packed.finish().unwrap();
    let chunk = [
        &[0; 16][..],
        &(PART as u64).to_le_bytes(),
        &[0; 4],
        &mcap_text("lz4"),
        &(packed.len() as u64).to_le_bytes(),
        &packed,
    ]
    .concat();
    [&b"\x89MCAP0\r\n"[..], &mcap_topic(), &mcap_message("{\"a\": 1}"), &mcap_record(6, &chunk).repeat(PARTS)].concat()
}

/// One message of many numbers, and many messages of none.
fn mcap_columns() -> Vec<u8> {
    let fields: Vec<String> = (0..4000).map(|index| format!("\"a{index}\": 1")).collect();
    let wide = mcap_message(&format!("{{{}}}", fields.join(",")));
    [&b"\x89MCAP0\r\n"[..], &mcap_topic(), &wide, &mcap_message("{}").repeat(20_000), &mcap_record(15, &[0; 4])]
        .concat()
}

/// A block of MDF 4.
fn block(id: &[u8; 2], links: &[usize], data: &[u8]) -> Vec<u8> {
    let length = (24 + 8 * links.len() + data.len()) as u64;
    let links: Vec<u8> = links.iter().flat_map(|link| (*link as u64).to_le_bytes()).collect();
    [&b"##"[..], id, &[0; 4], &length.to_le_bytes(), &((links.len() / 8) as u64).to_le_bytes(), &links, data].concat()
}

/// Bytes of the blocks of [`mdf4`].
const HD: usize = 64;
const DG: usize = HD + 24 + 8 + 8;
const CN: usize = DG + 24 + 3 * 8 + 8;
const REST: usize = CN + 24 + 8 * 8 + 24;

/// A file with one data group whose channel groups and records are `rest`, and one channel of a byte.
fn mdf4(groups: usize, records: usize, id_bytes: u8, rest: &[u8]) -> Vec<u8> {
    let mut head = b"MDF     4.10    ".to_vec();
    head.resize(HD, 0);
    // Kind, sync, type (unsigned), bit offset, byte offset, bits, flags, place of the invalid bit.
    let channel = [&[0, 0, 0, 0][..], &0_u32.to_le_bytes(), &8_u32.to_le_bytes(), &[0; 12]].concat();
    [
        head,
        block(b"HD", &[DG], &[0; 8]),
        block(b"DG", &[0, groups, records], &[id_bytes, 0, 0, 0, 0, 0, 0, 0]),
        block(b"CN", &[0; 8], &channel),
        rest.to_vec(),
    ]
    .concat()
}

/// A channel group of records of one byte, behind which `next` follows.
fn channel_group(next: usize) -> Vec<u8> {
    let data = [&[0; 16][..], &[0; 8], &1_u32.to_le_bytes(), &0_u32.to_le_bytes()].concat();
    block(b"CG", &[next, CN, 0, 0, 0, 0], &data)
}

/// Compressed records.
fn mdf4_blocks() -> Vec<u8> {
    let mut packed = ZlibEncoder::new(Vec::new(), Compression::best());
    packed.write_all(&vec![0; PART]).unwrap();
    let packed = packed.finish().unwrap();
    let data =
        [&b"DT\0\0"[..], &[0; 4], &(PART as u64).to_le_bytes(), &(packed.len() as u64).to_le_bytes(), &packed].concat();
    let group = channel_group(0);
    let list_at = REST + group.len();
    let first = list_at + 24 + 8 * (PARTS + 1);
    let part = block(b"DZ", &[], &data);
    let places: Vec<usize> = std::iter::once(0).chain((0..PARTS).map(|index| first + index * part.len())).collect();
    mdf4(REST, list_at, 0, &[group, block(b"DL", &places, &[]), part.repeat(PARTS)].concat())
}

/// Groups that all have the same channels.
fn mdf4_shared_channels() -> Vec<u8> {
    const GROUPS: usize = 9000;
    let length = channel_group(0).len();
    let place = |index: usize| if index < GROUPS { REST + index * length } else { 0 };
    let groups: Vec<u8> = (0..GROUPS).flat_map(|index| channel_group(place(index + 1))).collect();
    mdf4(REST, 0, 1, &groups)
}

/// One column of equal numbers.
fn parquet() -> Vec<u8> {
    use parquet::data_type::Int64Type;
    use parquet::file::properties::WriterProperties;
    use parquet::file::writer::SerializedFileWriter;
    use parquet::schema::parser::parse_message_type;
    let schema = std::sync::Arc::new(parse_message_type("message table { required int64 p; }").unwrap());
    let properties = std::sync::Arc::new(WriterProperties::builder().build());
    let mut file = SerializedFileWriter::new(Vec::new(), schema, properties).unwrap();
    for _ in 0..PARTS {
        let mut group = file.next_row_group().unwrap();
        let mut column = group.next_column().unwrap().unwrap();
        column.typed::<Int64Type>().write_batch(&vec![7; PART / 8], None, None).unwrap();
        column.close().unwrap();
        group.close().unwrap();
    }
    file.into_inner().unwrap()
}
