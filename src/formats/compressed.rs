//! Files compressed by gzip.

use std::io::Read;
use std::path::Path;

use flate2::read::MultiGzDecoder;

/// Whether a file's ending is that of one.
pub fn is_compressed(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("gz"))
}

/// What was compressed, of at most `most` bytes.
///
/// # Errors
/// In words that follow the file's name.
pub fn gunzip(bytes: &[u8], most: u64) -> Result<Vec<u8>, String> {
    let mut whole = Vec::new();
    let read = MultiGzDecoder::new(bytes).take(most.saturating_add(1)).read_to_end(&mut whole);
    match read {
        Ok(length) if length as u64 > most => Err(format!("holds more than {most} bytes")),
        Ok(_) => Ok(whole),
        Err(error) => Err(format!("cannot be uncompressed: {error}")),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use flate2::Compression;
    use flate2::write::GzEncoder;

    use super::*;

    #[test]
    fn what_was_compressed_comes_back_within_bounds() {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(&[7; 1000]).unwrap();
        let bytes = encoder.finish().unwrap();
        assert_eq!(gunzip(&bytes, 1000), Ok(vec![7; 1000]));
        assert!(gunzip(&bytes, 999).unwrap_err().contains("more than 999"));
        assert!(gunzip(&bytes[..10], 1000).is_err() && gunzip(b"plain", 1000).is_err());
        assert!(is_compressed(Path::new("a/b.ply.GZ")) && !is_compressed(Path::new("gz")));
    }
}
