//! Long lists of numbers as one piece of bytes, for messages between the page and its worker.
//!
//! `#[serde(with = "crate::bulk")]` writes a list as little-endian bytes where the format is binary, and element by
//! element where people read it (JSON). Reading a cloud of 240 000 points element by element kept the page from drawing
//! for 140 ms.

use std::fmt;
use std::marker::PhantomData;

use nalgebra::Point3;
use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::segment::PointFate;

/// What a list of can be one piece of bytes.
///
/// `pack` and `unpack` take whole lists, not elements: as functions without parameters they are compiled here, for
/// speed, whatever the crate is compiled for that calls them.
pub(crate) trait Bulk: Sized {
    /// The bytes of a list.
    fn pack(list: &[Self]) -> Vec<u8>;
    /// The list of bytes; `None` if no list has them.
    fn unpack(bytes: &[u8]) -> Option<Vec<Self>>;
}

/// Elements of `SIZE` bytes each.
fn pack<T, const SIZE: usize>(list: &[T], put: impl Fn(&T) -> [u8; SIZE]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(SIZE * list.len());
    list.iter().for_each(|element| bytes.extend_from_slice(&put(element)));
    bytes
}

fn unpack<T, const SIZE: usize>(bytes: &[u8], take: impl Fn(&[u8; SIZE]) -> Option<T>) -> Option<Vec<T>> {
    let (elements, rest) = bytes.as_chunks::<SIZE>();
    if rest.is_empty() { elements.iter().map(take).collect() } else { None }
}

impl Bulk for f64 {
    fn pack(list: &[Self]) -> Vec<u8> {
        pack(list, |x| x.to_le_bytes())
    }

    fn unpack(bytes: &[u8]) -> Option<Vec<Self>> {
        unpack(bytes, |x| Some(Self::from_le_bytes(*x)))
    }
}

impl Bulk for u32 {
    fn pack(list: &[Self]) -> Vec<u8> {
        pack(list, |x| x.to_le_bytes())
    }

    fn unpack(bytes: &[u8]) -> Option<Vec<Self>> {
        unpack(bytes, |x| Some(Self::from_le_bytes(*x)))
    }
}

impl Bulk for u8 {
    fn pack(list: &[Self]) -> Vec<u8> {
        list.to_vec()
    }

    fn unpack(bytes: &[u8]) -> Option<Vec<Self>> {
        Some(bytes.to_vec())
    }
}

impl Bulk for [u8; 3] {
    fn pack(list: &[Self]) -> Vec<u8> {
        list.as_flattened().to_vec()
    }

    fn unpack(bytes: &[u8]) -> Option<Vec<Self>> {
        unpack(bytes, |rgb| Some(*rgb))
    }
}

impl Bulk for Point3<f64> {
    fn pack(list: &[Self]) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(24 * list.len());
        list.iter().flat_map(|p| p.iter()).for_each(|x| bytes.extend_from_slice(&x.to_le_bytes()));
        bytes
    }

    fn unpack(bytes: &[u8]) -> Option<Vec<Self>> {
        unpack(bytes, |xyz: &[u8; 24]| {
            let [x, y, z] = xyz.as_chunks().0 else { return None };
            Some(Self::new(f64::from_le_bytes(*x), f64::from_le_bytes(*y), f64::from_le_bytes(*z)))
        })
    }
}

/// Fates with their number: the cluster of [`PointFate::Cluster`] goes into the two bytes behind it.
const FATES: [PointFate; 8] = [
    PointFate::Table,
    PointFate::Cluster(0),
    PointFate::BelowTable,
    PointFate::TooLow,
    PointFate::TooHigh,
    PointFate::OffTable,
    PointFate::SmallCluster,
    PointFate::KnownObstacle,
];

impl Bulk for PointFate {
    fn pack(list: &[Self]) -> Vec<u8> {
        pack(list, |fate| {
            let (kind, cluster) = match *fate {
                Self::Cluster(cluster) => (1, cluster),
                other => (FATES.iter().position(|fate| *fate == other).unwrap_or(0) as u8, 0),
            };
            let [low, high] = cluster.to_le_bytes();
            [kind, low, high]
        })
    }

    fn unpack(bytes: &[u8]) -> Option<Vec<Self>> {
        unpack(bytes, |[kind, low, high]| match FATES.get(usize::from(*kind)).copied()? {
            Self::Cluster(_) => Some(Self::Cluster(u16::from_le_bytes([*low, *high]))),
            other => Some(other),
        })
    }
}

pub(crate) fn serialize<T: Bulk + Serialize, S: Serializer>(list: &[T], to: S) -> Result<S::Ok, S::Error> {
    if to.is_human_readable() { list.serialize(to) } else { to.serialize_bytes(&T::pack(list)) }
}

pub(crate) fn deserialize<'de, T: Bulk + Deserialize<'de>, D: Deserializer<'de>>(from: D) -> Result<Vec<T>, D::Error> {
    if from.is_human_readable() { Vec::deserialize(from) } else { from.deserialize_bytes(Piece(PhantomData)) }
}

/// Reads one piece of bytes.
struct Piece<T>(PhantomData<T>);

impl<T: Bulk> Visitor<'_> for Piece<T> {
    type Value = Vec<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a list as bytes")
    }

    fn visit_bytes<E: Error>(self, bytes: &[u8]) -> Result<Vec<T>, E> {
        T::unpack(bytes).ok_or_else(|| E::custom(format!("{} bytes are no list of such elements", bytes.len())))
    }
}

/// The same for a list of lists.
pub(crate) mod lists {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use super::Bulk;

    #[derive(Serialize)]
    #[serde(transparent, bound = "T: Bulk + Serialize")]
    struct Lent<'a, T>(#[serde(serialize_with = "super::serialize")] &'a [T]);

    #[derive(Deserialize)]
    #[serde(transparent, bound = "T: Bulk + Deserialize<'de>")]
    struct Given<T>(#[serde(deserialize_with = "super::deserialize")] Vec<T>);

    pub(crate) fn serialize<T: Bulk + Serialize, S: Serializer>(lists: &[Vec<T>], to: S) -> Result<S::Ok, S::Error> {
        to.collect_seq(lists.iter().map(|list| Lent(list)))
    }

    pub(crate) fn deserialize<'de, T: Bulk + Deserialize<'de>, D: Deserializer<'de>>(
        from: D,
    ) -> Result<Vec<Vec<T>>, D::Error> {
        Ok(Vec::<Given<T>>::deserialize(from)?.into_iter().map(|list| list.0).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_come_back_from_their_bytes_to_the_last_bit() {
        fn comes_back<T: Bulk + PartialEq + fmt::Debug>(list: &[T], bytes: usize) {
            let packed = T::pack(list);
            assert_eq!(packed.len(), bytes);
            assert_eq!(T::unpack(&packed).unwrap(), list);
        }
        comes_back(&[0.1, -0.0, f64::MIN_POSITIVE], 24);
        comes_back(&[Point3::new(0.1, 2.0, -3.0), Point3::new(1e-300, 1e300, 0.0)], 48);
        comes_back(&[1_u32, u32::MAX], 8);
        comes_back(&[[1_u8, 2, 255]], 3);
        comes_back(b"abc", 3);
        comes_back(&[PointFate::Cluster(u16::MAX), PointFate::KnownObstacle, PointFate::Table], 9);
        comes_back(&FATES, 24);
    }

    #[test]
    fn bytes_that_are_no_list_are_refused() {
        assert_eq!(f64::unpack(&[0; 9]), None);
        assert_eq!(Point3::unpack(&[0; 25]), None);
        assert_eq!(PointFate::unpack(&[8, 0, 0]), None, "there is no such fate");
        assert_eq!(f64::unpack(&[]), Some(Vec::new()));
    }

    #[test]
    fn people_read_elements() {
        #[derive(Serialize, Deserialize)]
        struct Read {
            #[serde(with = "crate::bulk")]
            heights_m: Vec<f64>,
            #[serde(with = "lists")]
            rows: Vec<Vec<u32>>,
        }
        let text = r#"{"heights_m":[0.5,1.0],"rows":[[1],[],[2,3]]}"#;
        let read: Read = serde_json::from_str(text).unwrap();
        assert_eq!(serde_json::to_string(&read).unwrap(), text);
    }
}
