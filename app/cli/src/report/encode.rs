//! Numbers as text: little-endian bytes in base 64.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

fn encode<const BYTES: usize>(bytes: impl Iterator<Item = [u8; BYTES]>) -> String {
    STANDARD.encode(bytes.flatten().collect::<Vec<u8>>())
}

/// 16-bit numbers.
pub(super) fn of_u16(numbers: &[u16]) -> String {
    encode(numbers.iter().map(|x| x.to_le_bytes()))
}

/// 32-bit numbers.
pub(super) fn of_u32(numbers: &[u32]) -> String {
    encode(numbers.iter().map(|x| x.to_le_bytes()))
}

/// Numbers of single precision.
pub(super) fn of_f32(numbers: impl IntoIterator<Item = f64>) -> String {
    encode(numbers.into_iter().map(|x| (x as f32).to_le_bytes()))
}

/// Encodes multiples of `unit` as signed 16-bit numbers, clamped to their range.
pub(super) fn of_i16(numbers: impl IntoIterator<Item = f64>, unit: f64) -> String {
    encode(numbers.into_iter().map(|x| {
        // The cast saturates.
        ((x / unit).round() as i16).to_le_bytes()
    }))
}
