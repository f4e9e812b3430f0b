//! Names as Cryptomatte keeps them: a hash as the bits of a float, and a manifest in the file's header that says which hash is whose.
//!
//! Source: Friedman and Jones 2015, Cryptomatte specification 1.2.0; MurmurHash3 (Appleby, public domain), x86, 32 bits, seed 0.

/// MurmurHash3 of 32 bits.
pub fn murmur3(bytes: &[u8]) -> u32 {
    let scramble = |k: u32| k.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let chunks = bytes.chunks_exact(4);
    let tail = chunks.remainder();
    let mut h = chunks.fold(0u32, |h, c| {
        let k = u32::from_le_bytes([c[0], c[1], c[2], c[3]]);
        (h ^ scramble(k)).rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64)
    });
    if !tail.is_empty() {
        h ^= scramble(tail.iter().rev().fold(0, |k, b| k << 8 | u32::from(*b)));
    }
    h ^= bytes.len() as u32;
    h = (h ^ h >> 16).wrapping_mul(0x85eb_ca6b);
    h = (h ^ h >> 13).wrapping_mul(0xc2b2_ae35);
    h ^ h >> 16
}

/// The hash of a name as the bits of an ordinary float: never zero's, infinity's or NaN's exponent.
pub fn name_bits(name: &str) -> u32 {
    let hash = murmur3(name.as_bytes());
    let exponent = (hash >> 23 & 255).clamp(1, 254);
    hash & 0x807f_ffff | exponent << 23
}

/// Header attributes of the layer `layer` ("ViewLayer.CryptoObject"): name and text of each.
pub fn attributes<'a>(layer: &str, names: impl IntoIterator<Item = &'a str>) -> Vec<(String, String)> {
    let names: std::collections::BTreeSet<&str> = names.into_iter().collect();
    let manifest: serde_json::Map<String, serde_json::Value> =
        names.into_iter().map(|n| (n.to_owned(), format!("{:08x}", name_bits(n)).into())).collect();
    let id = &format!("{:08x}", murmur3(layer.as_bytes()))[..7];
    let texts = [
        ("name", layer.to_owned()),
        ("hash", "MurmurHash3_32".to_owned()),
        ("conversion", "uint32_to_float32".to_owned()),
        ("manifest", serde_json::Value::Object(manifest).to_string()),
    ];
    let mut out: Vec<(String, String)> = texts.into_iter().map(|(key, text)| (format!("cryptomatte/{id}/{key}"), text)).collect();
    out.sort();
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_are_those_that_blender_writes() {
        // Source: header of a file that Blender 4.5.15 rendered from 04_principled_lobes.blend.
        for (name, bits) in [("Floor", 0x6a2f_b16e), ("L0", 0x0df1_22a8), ("L1", 0x5b13_7744), ("default_surface", 0x78d0_5529)] {
            assert_eq!(name_bits(name), bits, "{name}");
        }
        assert_eq!(&format!("{:08x}", murmur3(b"ViewLayer.CryptoObject"))[..7], "542cafa");
        assert_eq!(murmur3(b""), 0);
    }

    #[test]
    fn no_hash_is_an_unusual_float() {
        for k in 0..20_000 {
            assert!(f32::from_bits(name_bits(&format!("name {k}"))).is_normal());
        }
    }
}
