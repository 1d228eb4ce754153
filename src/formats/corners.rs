//! Corners of faces as they come from a file, before the vertices that they name are known.

use super::polygon::{MAX_CORNERS, too_many_corners};

/// Lists of indices of vertices, one after the other: polygons, or strips of triangles.
#[derive(Debug, Clone, Default)]
pub(super) struct CornerLists {
    pub corners: Vec<u32>,
    /// Where each list ends.
    ends: Vec<usize>,
    /// Where each list stands, in text formats.
    lines: Vec<u32>,
}

/// One list of corners.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct CornerList<'a> {
    pub corners: &'a [u32],
    pub line: Option<usize>,
}

impl CornerLists {
    /// How many lists are closed.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// How many corners the list has that is not yet closed.
    pub fn open_corners(&self) -> usize {
        self.corners.len() - self.start_of_open()
    }

    fn start_of_open(&self) -> usize {
        self.ends.last().copied().unwrap_or_default()
    }

    /// Makes a list of the corners since the last.
    pub fn close(&mut self, line: Option<usize>) {
        self.ends.push(self.corners.len());
        if let Some(line) = line {
            self.lines.push(u32::try_from(line).unwrap_or(u32::MAX));
        }
    }

    /// Makes a polygon of the corners since the last, unless there are too many.
    pub fn close_polygon(&mut self, line: Option<usize>) -> Result<(), String> {
        let corners = self.open_corners();
        if corners > MAX_CORNERS {
            return Err(too_many_corners(corners));
        }
        self.close(line);
        Ok(())
    }

    /// Forgets the corners since the last list.
    pub fn discard(&mut self) {
        let start = self.start_of_open();
        self.corners.truncate(start);
    }

    pub fn iter(&self) -> impl Iterator<Item = CornerList<'_>> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).enumerate().map(|(i, (start, &end))| CornerList {
            corners: &self.corners[start..end],
            line: self.lines.get(i).map(|&line| line as usize),
        })
    }

    /// Which of all corners are those of a list, by its number.
    pub fn corners_of(&self, index: usize) -> std::ops::Range<usize> {
        index.checked_sub(1).map_or(0, |before| self.ends[before])..self.ends[index]
    }

    /// One list by its number.
    pub fn get(&self, index: usize) -> CornerList<'_> {
        CornerList {
            corners: &self.corners[self.corners_of(index)],
            line: self.lines.get(index).map(|&line| line as usize),
        }
    }

    /// The corners of lists that make a face.
    pub fn used(&self) -> impl Iterator<Item = u32> {
        self.iter().filter(CornerList::is_face).flat_map(|list| list.corners.iter().copied())
    }

    /// The first list that makes a face and names a vertex at or beyond `vertices`: its number, the vertex and its line.
    pub fn out_of_range(&self, vertices: usize) -> Option<(usize, u32, Option<usize>)> {
        let beyond = |corners: &[u32]| corners.iter().copied().find(|&corner| corner as usize >= vertices);
        beyond(&self.corners)?;
        let mut faces = self.iter().enumerate().filter(|(_, list)| list.is_face());
        faces.find_map(|(number, list)| Some((number, beyond(list.corners)?, list.line)))
    }
}

impl CornerList<'_> {
    pub fn is_face(&self) -> bool {
        self.corners.len() >= 3
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_keep_their_places() {
        let mut lists = CornerLists::default();
        lists.corners.extend([0, 1, 2]);
        lists.close(Some(4));
        lists.corners.extend([9, 9]);
        lists.close(Some(5));
        lists.corners.extend([7, 7]);
        lists.discard();
        lists.corners.extend([2, 3, 4, 5]);
        assert_eq!(lists.open_corners(), 4);
        lists.close_polygon(Some(7)).unwrap();
        let all: Vec<_> = lists.iter().map(|list| (list.corners.to_vec(), list.line)).collect();
        assert_eq!(all, [(vec![0, 1, 2], Some(4)), (vec![9, 9], Some(5)), (vec![2, 3, 4, 5], Some(7))]);
        assert_eq!(lists.used().collect::<Vec<_>>(), [0, 1, 2, 2, 3, 4, 5]);
        // What makes no face may name anything.
        assert_eq!((lists.out_of_range(6), lists.out_of_range(5)), (None, Some((2, 5, Some(7)))));
        lists.corners.resize(MAX_CORNERS + 10, 0);
        assert!(lists.close_polygon(None).unwrap_err().contains("at most"));
    }
}
