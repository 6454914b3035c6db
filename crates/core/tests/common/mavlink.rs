//! MAVLink packets as an autopilot sends them.

use doublet_core::load::stream::{FieldType, Message, packet_checksum};

/// A packet of version 1 or 2 with the numbers on the wire.
pub fn packet(message: &Message, values: &[f64], version: u8, sequence: u8) -> Vec<u8> {
    let mut payload = Vec::new();
    for (field, value) in message.fields.iter().zip(values) {
        match field.kind {
            FieldType::U64 => payload.extend((*value as u64).to_le_bytes()),
            FieldType::U32 => payload.extend((*value as u32).to_le_bytes()),
            FieldType::I32 => payload.extend((*value as i32).to_le_bytes()),
            FieldType::F32 => payload.extend((*value as f32).to_le_bytes()),
            FieldType::U16 => payload.extend((*value as u16).to_le_bytes()),
            FieldType::I16 => payload.extend((*value as i16).to_le_bytes()),
            FieldType::U8 => payload.extend((*value as u8).to_le_bytes()),
        }
    }
    let mut bytes = if version == 2 {
        while payload.len() > 1 && payload.last() == Some(&0) {
            payload.pop();
        }
        let [a, b, c, _] = message.id.to_le_bytes();
        vec![0xfd, payload.len() as u8, 0, 0, sequence, 1, 1, a, b, c]
    } else {
        vec![0xfe, payload.len() as u8, sequence, 1, 1, message.id as u8]
    };
    bytes.extend(payload);
    let sum = packet_checksum(&bytes[1..], message.checksum_seed());
    bytes.extend(sum.to_le_bytes());
    bytes
}
