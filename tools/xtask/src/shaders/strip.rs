//! Takes source text and line numbers out of SPIR-V and leaves the names.

use crate::Result;

const MAGIC: u32 = 0x0723_0203;
/// Words before the first instruction (SPIR-V specification, section 2.3).
const HEADER: usize = 5;

const OP_SOURCE_CONTINUED: u32 = 2;
const OP_SOURCE: u32 = 3;
const OP_SOURCE_EXTENSION: u32 = 4;
const OP_STRING: u32 = 7;
const OP_LINE: u32 = 8;
const OP_NO_LINE: u32 = 317;
const OP_MODULE_PROCESSED: u32 = 330;

/// Removes every instruction that only a source-level debugger reads.
pub(crate) fn source_text(words: &[u32]) -> Result<Vec<u32>> {
    if words.first() != Some(&MAGIC) || words.len() < HEADER {
        return Err("not SPIR-V".into());
    }
    let mut kept = words[..HEADER].to_vec();
    let mut at = HEADER;
    while at < words.len() {
        let (length, opcode) = ((words[at] >> 16) as usize, words[at] & 0xffff);
        let instruction = words.get(at..at + length).filter(|i| !i.is_empty());
        let instruction = instruction.ok_or("SPIR-V ends within an instruction")?;
        if !is_source(opcode) {
            kept.extend_from_slice(instruction);
        }
        at += length;
    }
    Ok(kept)
}

fn is_source(opcode: u32) -> bool {
    matches!(
        opcode,
        OP_SOURCE_CONTINUED
            | OP_SOURCE
            | OP_SOURCE_EXTENSION
            | OP_STRING
            | OP_LINE
            | OP_NO_LINE
            | OP_MODULE_PROCESSED
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_go_and_names_stay() {
        let header = [MAGIC, 0x0001_0500, 0, 10, 0];
        let name = [3 << 16 | 5, 4, u32::from_le_bytes(*b"abc\0")];
        let line = [4 << 16 | OP_LINE, 1, 2, 3];
        let words = [&header[..], &line, &name, &line].concat();
        assert_eq!(source_text(&words), Ok([&header[..], &name].concat()));
    }

    #[test]
    fn damage_is_an_error() {
        assert!(source_text(&[1, 2, 3, 4, 5]).is_err());
        assert!(source_text(&[MAGIC, 0, 0, 0, 0, 9 << 16 | 5]).is_err());
        assert!(source_text(&[MAGIC, 0, 0, 0, 0, 0]).is_err());
    }
}
