//! Arrays of numbers in the buffers of a glTF file: interleaved, normalised and sparse ones too (glTF 2.0, section 3.6.2).

use glam::DVec3;

use super::container::Container;
use super::schema::{Accessor, SparsePart};
use super::surface::Budget;

/// Most elements of an accessor without bytes of its own, which are 0.
const MAX_ZEROS: u64 = 1 << 22;

/// The type of a number.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(code: u32) -> Result<Self, String> {
        Ok(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return Err(format!("has the componentType {code}, which is none")),
        })
    }

    fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The number at the start of `bytes`, which must be long enough. Normalised integers go from −1 or 0 to 1.
    fn number(self, bytes: &[u8], is_normalized: bool) -> f64 {
        let (number, most) = match self {
            Self::I8 => (f64::from(bytes[0] as i8), f64::from(i8::MAX)),
            Self::U8 => (f64::from(bytes[0]), f64::from(u8::MAX)),
            Self::I16 => (f64::from(i16::from_le_bytes([bytes[0], bytes[1]])), f64::from(i16::MAX)),
            Self::U16 => (f64::from(u16::from_le_bytes([bytes[0], bytes[1]])), f64::from(u16::MAX)),
            Self::U32 => (f64::from(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])), f64::from(u32::MAX)),
            Self::F32 => return f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
        };
        if is_normalized { (number / most).max(-1.0) } else { number }
    }
}

/// The elements of an accessor, as bytes: `None` where it has none of its own, and all are 0.
struct Elements<'a> {
    bytes: Option<&'a [u8]>,
    stride: usize,
    component: Component,
    is_normalized: bool,
    count: usize,
}

impl<'a> Elements<'a> {
    fn of(container: &'a Container, accessor: &Accessor, kind: &str) -> Result<Self, String> {
        if accessor.kind != kind {
            return Err(format!("has the type `{}`, must be {kind}", accessor.kind));
        }
        let component = Component::of(accessor.component_type)?;
        let numbers = match kind {
            "VEC4" => 4,
            "VEC3" => 3,
            "VEC2" => 2,
            _ => 1,
        };
        let size = component.bytes() * numbers;
        let Accessor { buffer_view, byte_offset, count, normalized, .. } = *accessor;
        let (bytes, stride) = match buffer_view {
            None if count > MAX_ZEROS => {
                return Err(format!("has {count} elements and no bufferView; at most {MAX_ZEROS} are read"));
            }
            None => (None, size),
            Some(view) => {
                let (bytes, view_of) = container.view(view)?;
                let stride = view_of.byte_stride.unwrap_or(size as u64);
                if stride < size as u64 {
                    return Err(format!(
                        "has elements of {size} bytes, but bufferView {view} has them every {stride} bytes"
                    ));
                }
                (
                    Some(
                        part(bytes, byte_offset, stride, size, count)
                            .ok_or_else(|| format!("ends beyond bufferView {view}"))?,
                    ),
                    stride as usize,
                )
            }
        };
        Ok(Self { bytes, stride, component, is_normalized: normalized, count: count as usize })
    }

    fn number(&self, element: usize, axis: usize) -> f64 {
        let at = element * self.stride + axis * self.component.bytes();
        self.bytes.map_or(0.0, |bytes| self.component.number(&bytes[at..], self.is_normalized))
    }
}

/// The bytes of `count` elements of `size` bytes, one every `stride`, from `offset` on; `None` where there are fewer.
fn part(bytes: &[u8], offset: u64, stride: u64, size: usize, count: u64) -> Option<&[u8]> {
    let length = match count {
        0 => 0,
        count => (count - 1).checked_mul(stride)?.checked_add(size as u64)?,
    };
    let end = offset.checked_add(length).filter(|end| *end <= bytes.len() as u64)?;
    Some(&bytes[offset as usize..end as usize])
}

impl Container {
    fn accessor(&self, index: usize) -> Result<&Accessor, String> {
        let accessors = &self.root.accessors;
        accessors.get(index).ok_or_else(|| format!("is not there: there are {} accessors", accessors.len()))
    }

    /// Vectors of three numbers.
    pub fn vectors(&self, index: usize, budget: &mut Budget) -> Result<Vec<DVec3>, String> {
        self.tuples(index, "VEC3", budget, DVec3::from_array)
    }

    /// Pairs of numbers.
    pub fn pairs(&self, index: usize, budget: &mut Budget) -> Result<Vec<[f64; 2]>, String> {
        self.tuples(index, "VEC2", budget, |pair| pair)
    }

    /// Colours, with or without opacity, which is left out.
    pub fn colors(&self, index: usize, budget: &mut Budget) -> Result<Vec<[f64; 3]>, String> {
        let kind = self.accessor(index).map_or("VEC3", |accessor| &accessor.kind);
        match kind {
            "VEC4" => self.tuples(index, kind, budget, |[red, green, blue, _]| [red, green, blue]),
            _ => self.tuples(index, "VEC3", budget, |color| color),
        }
    }

    fn tuples<T, const N: usize>(
        &self,
        index: usize,
        kind: &str,
        budget: &mut Budget,
        tuple: impl Fn([f64; N]) -> T,
    ) -> Result<Vec<T>, String> {
        let mut read = || {
            let accessor = self.accessor(index)?;
            let elements = Elements::of(self, accessor, kind)?;
            budget.take(accessor.count)?;
            let vector = |of: &Elements<'_>, i: usize| tuple(std::array::from_fn(|axis| of.number(i, axis)));
            let mut vectors: Vec<T> = (0..elements.count).map(|i| vector(&elements, i)).collect();
            if let Some(sparse) = &accessor.sparse {
                let places =
                    self.sparse_part(&sparse.indices, sparse.count, sparse.indices.component_type, "SCALAR", false)?;
                let values =
                    self.sparse_part(&sparse.values, sparse.count, accessor.component_type, kind, accessor.normalized)?;
                for i in 0..places.count {
                    let place = places.number(i, 0);
                    let count = vectors.len();
                    let to = vectors.get_mut(place as usize);
                    *to.ok_or_else(|| format!("replaces element {place} of {count}"))? = vector(&values, i);
                }
            }
            Ok(vectors)
        };
        read().map_err(|why: String| format!("accessor {index} {why}"))
    }

    /// Whole numbers from 0.
    pub fn indices(&self, index: usize, budget: &mut Budget) -> Result<Vec<u32>, String> {
        let mut read = || {
            let accessor = self.accessor(index)?;
            let elements = Elements::of(self, accessor, "SCALAR")?;
            budget.take(accessor.count)?;
            if !matches!(elements.component, Component::U8 | Component::U16 | Component::U32) {
                return Err(format!("has the componentType {}, which is none of indices", accessor.component_type));
            }
            let is_normalized = false;
            let elements = Elements { is_normalized, ..elements };
            let mut indices: Vec<u32> = (0..elements.count).map(|i| elements.number(i, 0) as u32).collect();
            if let Some(sparse) = &accessor.sparse {
                let places =
                    self.sparse_part(&sparse.indices, sparse.count, sparse.indices.component_type, "SCALAR", false)?;
                let values =
                    self.sparse_part(&sparse.values, sparse.count, accessor.component_type, "SCALAR", false)?;
                for i in 0..places.count {
                    let place = places.number(i, 0);
                    let count = indices.len();
                    *indices.get_mut(place as usize).ok_or_else(|| format!("replaces element {place} of {count}"))? =
                        values.number(i, 0) as u32;
                }
            }
            Ok(indices)
        };
        read().map_err(|why: String| format!("accessor {index} {why}"))
    }

    /// What stands in place of some elements, or which those are.
    fn sparse_part(
        &self,
        part: &SparsePart,
        count: u64,
        component_type: u32,
        kind: &str,
        normalized: bool,
    ) -> Result<Elements<'_>, String> {
        let accessor = Accessor {
            buffer_view: Some(part.buffer_view),
            byte_offset: part.byte_offset,
            component_type,
            normalized,
            count,
            kind: kind.to_owned(),
            sparse: None,
        };
        Elements::of(self, &accessor, kind).map_err(|why| format!("has sparse values: that {why}"))
    }
}
