//! Text in an address: deflate (RFC 1951), then base64url without padding (RFC 4648, section 5).

use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use miniz_oxide::deflate::compress_to_vec;
use miniz_oxide::inflate::{TINFLStatus, decompress_to_vec_with_limit};

use super::ShareError;

/// A link unpacks to no more than this, bytes: a scene with a hand of a person's own has some hundred thousand.
pub(super) const MAX_UNPACKED_BYTES: usize = 4 << 20;
/// As small as the packer gets it; a link is packed when somebody asks for it.
const LEVEL: u8 = 10;

/// Packs text into characters that an address may hold.
pub(super) fn pack(text: &str) -> String {
    URL_SAFE_NO_PAD.encode(compress_to_vec(text.as_bytes(), LEVEL))
}

/// The text that was packed.
///
/// # Errors
/// [`ShareError::Base64`], [`ShareError::Deflate`], [`ShareError::TooLarge`], or [`ShareError::Format`] for bytes that
/// are no text.
pub(super) fn unpack(packed: &str) -> Result<String, ShareError> {
    let bytes = URL_SAFE_NO_PAD.decode(packed).map_err(|error| ShareError::Base64 { reason: error.to_string() })?;
    let unpacked = decompress_to_vec_with_limit(&bytes, MAX_UNPACKED_BYTES).map_err(|error| match error.status {
        TINFLStatus::HasMoreOutput => ShareError::TooLarge { limit: MAX_UNPACKED_BYTES },
        _ => ShareError::Deflate,
    })?;
    String::from_utf8(unpacked).map_err(|error| ShareError::Format { reason: error.to_string() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_packed_is_unpacked_and_needs_no_escapes_in_an_address() {
        for text in ["", "{}", "ünïcödé ≤ 3", &"a long text ".repeat(1000)] {
            let packed = pack(text);
            assert_eq!(unpack(&packed).as_deref(), Ok(text));
            assert!(packed.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '-' | '_')), "{packed}");
        }
    }

    #[test]
    fn broken_packings_say_what_is_wrong() {
        assert!(matches!(unpack("a b"), Err(ShareError::Base64 { .. })));
        assert_eq!(unpack(&URL_SAFE_NO_PAD.encode("no deflate at all")), Err(ShareError::Deflate));
        let packed = pack(&"a long text ".repeat(100));
        assert!(unpack(&packed[..packed.len() - 8]).is_err(), "cut off");
        assert!(matches!(
            unpack(&URL_SAFE_NO_PAD.encode(compress_to_vec(&[0xff, 0xfe], 1))),
            Err(ShareError::Format { .. })
        ));
    }

    #[test]
    fn a_small_link_that_unpacks_to_something_huge_is_refused_at_the_limit() {
        let fits = compress_to_vec(&vec![b' '; MAX_UNPACKED_BYTES], 9);
        assert_eq!(unpack(&URL_SAFE_NO_PAD.encode(fits)).map(|text| text.len()), Ok(MAX_UNPACKED_BYTES));
        let bomb = compress_to_vec(&vec![b' '; MAX_UNPACKED_BYTES + 1], 9);
        assert!(bomb.len() < 10_000, "{} bytes", bomb.len());
        assert_eq!(unpack(&URL_SAFE_NO_PAD.encode(bomb)), Err(ShareError::TooLarge { limit: MAX_UNPACKED_BYTES }));
    }
}
