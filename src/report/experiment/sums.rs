//! What bias and variance are worked out from: sums over images with different seeds.

/// An image, linear RGB, row 0 at the top.
pub type Image = Vec<[f32; 3]>;

/// Of one component of some images.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sums {
    /// Of x − r: near the truth little is lost to cancellation.
    pub values: f64,
    squares: f64,
}

impl Sums {
    pub fn of(images: &[&Image], pixel: usize, channel: usize, reference: f64) -> Self {
        let mut sums = Self::default();
        for image in images {
            sums.add(f64::from(image[pixel][channel]) - reference);
        }
        sums
    }

    pub fn add(&mut self, x: f64) {
        self.values += x;
        self.squares += x * x;
    }

    pub fn without(self, x: f64) -> Self {
        Self { values: self.values - x, squares: self.squares - x * x }
    }

    /// Sample variance of `count` runs.
    pub fn variance(self, count: f64) -> f64 {
        (self.squares - self.values * self.values / count) / (count - 1.0)
    }

    /// The square of what the runs share: the mean of all products of two different runs.
    pub fn squared_mean(self, count: f64) -> f64 {
        (self.values * self.values - self.squares) / (count * (count - 1.0))
    }
}
