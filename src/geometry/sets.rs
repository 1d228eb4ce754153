//! Disjoint sets of numbers (Tarjan 1975).

/// The numbers below some count, each with one on its way to the smallest of its set.
pub struct Sets(Vec<u32>);

impl Sets {
    /// Each number by itself.
    pub fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    /// What stands for the set of `member`: its smallest.
    pub fn find(&mut self, member: u32) -> u32 {
        let mut root = member;
        while self.0[root as usize] != root {
            let parent = self.0[root as usize];
            self.0[root as usize] = self.0[parent as usize];
            root = parent;
        }
        root
    }

    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b) as usize] = a.min(b);
    }

    /// What stands for each number; `None` where no two were joined.
    pub fn joined(mut self) -> Option<Vec<u32>> {
        let roots: Vec<u32> = (0..self.0.len() as u32).map(|member| self.find(member)).collect();
        roots.iter().zip(0..).any(|(root, member)| *root != member).then_some(roots)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_are_joined() {
        let mut sets = Sets::new(6);
        sets.join(4, 2);
        sets.join(5, 4);
        sets.join(1, 0);
        assert_eq!(sets.joined(), Some(vec![0, 0, 2, 3, 2, 2]));
        assert_eq!(Sets::new(3).joined(), None);
    }
}
