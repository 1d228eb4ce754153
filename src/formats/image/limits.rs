//! How large images may be. Tested on their headers, before anything is decoded or allocated.

use exr::meta::BlockDescription;
use exr::meta::header::Header;

/// Most pixels of an image, such as 16384×16384 or 23170×11585.
///
/// Reading takes 12 bytes a pixel for the result, plus what the format needs: rows or blocks (HDR, PNG, EXR), or the decoded bytes (JPEG:
/// 3 bytes a pixel, 9 if it is progressive). Sampling an environment takes 4 more. At this limit that is 4.3 GB in all.
pub(crate) const MAX_PIXELS: u64 = 1 << 28;

/// Most bytes of one decompressed block of an OpenEXR file: a tile, or up to 256 rows, with all of its channels.
const MAX_BLOCK_BYTES: u64 = 1 << 30;

/// How many pixels an image of this size has; an error where that is none, or too many to be read.
pub(crate) fn pixel_count(width: u64, height: u64) -> Result<usize, String> {
    match width.checked_mul(height) {
        Some(0) => Err(format!("has no pixels: it is {width}×{height}")),
        Some(count) if count <= MAX_PIXELS => Ok(count as usize),
        _ => Err(format!(
            "is {width}×{height} pixels large; at most {MAX_PIXELS} pixels are read, such as 23170×11585: scale it down"
        )),
    }
}

/// An image without light. Its memory is not touched before it is written to, so that a file that is cut off does not take the room of a
/// whole one.
pub(super) fn black(count: usize) -> Result<Vec<[f32; 3]>, String> {
    zeroed(count)
}

/// The same of other pixels.
pub(super) fn zeroed<P: bytemuck::Pod>(count: usize) -> Result<Vec<P>, String> {
    let fits = Vec::<P>::new().try_reserve_exact(count);
    fits.map_err(|_| format!("has {count} pixels, for which there is not enough memory: scale it down"))?;
    Ok(bytemuck::zeroed_vec(count))
}

/// Tests both windows and the blocks of every part of an OpenEXR file; an error says what is too large.
pub(crate) fn check_exr(headers: &[Header]) -> Result<(), String> {
    for header in headers {
        for size in [header.layer_size, header.shared_attributes.display_window.size] {
            pixel_count(size.0 as u64, size.1 as u64)?;
        }
        let (columns, rows) = match header.blocks {
            BlockDescription::Tiles(tiles) => (tiles.tile_size.0, tiles.tile_size.1),
            BlockDescription::ScanLines => (header.layer_size.0, header.compression.scan_lines_per_block()),
        };
        let pixels = (columns as u64).checked_mul(rows as u64);
        let bytes = pixels.and_then(|pixels| pixels.checked_mul(header.channels.bytes_per_pixel as u64));
        if bytes.is_none_or(|bytes| bytes > MAX_BLOCK_BYTES) {
            return Err(format!(
                "is stored in blocks of {columns}×{rows} pixels and {} channels; at most {MAX_BLOCK_BYTES} bytes a block are read: \
                 save it with smaller tiles or fewer channels",
                header.channels.list.len()
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_that_are_read_and_refused() {
        assert_eq!(pixel_count(16384, 8192), Ok(16384 * 8192));
        assert_eq!(pixel_count(16384, 16384), Ok(1 << 28));
        assert_eq!(pixel_count(1 << 28, 1), Ok(1 << 28));
        for (width, height) in [(16385, 16384), (23000, 23000), (1 << 63, 2), (u64::MAX, u64::MAX)] {
            assert!(pixel_count(width, height).unwrap_err().contains("scale it down"), "{width}×{height}");
        }
        assert!(pixel_count(0, 5).unwrap_err().contains("no pixels"));
    }
}
