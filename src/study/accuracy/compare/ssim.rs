//! Structural similarity: Wang, Bovik, Sheikh, Simoncelli, "Image quality assessment: from error visibility to structural
//! similarity", 2004; with its window, a bell of deviation 1.5 over 11x11 pixels, and its constants for values in [0, 1].

use super::{
    Picture, encoded,
    filter::{Plane, bell, normalised, weights},
};

const C1: f32 = 0.01 * 0.01;
const C2: f32 = 0.03 * 0.03;

/// The mean over all pixels, of brightness as sRGB: 1 for equal images, about 0 for unrelated ones.
///
/// # Panics
/// If their sizes differ.
pub fn ssim(right: &Picture, image: &Picture) -> f64 {
    assert_eq!(right.size, image.size, "images of one size");
    let window = normalised(weights(5, bell(1.5)));
    let mean = |plane: &Plane| plane.filtered(&window, &window);
    let (a, b) = (brightness(right), brightness(image));
    let (ma, mb) = (mean(&a), mean(&b));
    let (aa, bb) = (mean(&a.with(&a, |a, b| a * b)), mean(&b.with(&b, |a, b| a * b)));
    let ab = mean(&a.with(&b, |a, b| a * b));
    let local = |i: usize| {
        let (ma, mb) = (ma.values[i], mb.values[i]);
        let (va, vb) = ((aa.values[i] - ma * ma).max(0.0), (bb.values[i] - mb * mb).max(0.0));
        let vab = ab.values[i] - ma * mb;
        let like = (2.0 * ma * mb + C1) * (2.0 * vab + C2);
        f64::from(like / ((ma * ma + mb * mb + C1) * (va + vb + C2)))
    };
    let count = a.values.len();
    (0..count).map(local).sum::<f64>() / count.max(1) as f64
}

/// Luma (ITU-R BT.709) of sRGB values.
fn brightness(picture: &Picture) -> Plane {
    let luma = |&[r, g, b]: &[f32; 3]| 0.2126 * encoded(r) + 0.7152 * encoded(g) + 0.0722 * encoded(b);
    Plane::new(picture.size, picture.pixels.iter().map(luma))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flat_images_differ_by_brightness_alone() {
        let flat = |value| Picture::new([16, 12], vec![[value; 3]; 192]);
        let (a, b) = (f64::from(encoded(0.2)), f64::from(encoded(0.6)));
        let c = f64::from(C1);
        let expected = (2.0 * a * b + c) / (a * a + b * b + c);
        let got = ssim(&flat(0.2), &flat(0.6));
        assert!((got - expected).abs() < 1e-4, "{got} {expected}");
        assert!((ssim(&flat(0.2), &flat(0.2)) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_negative_is_unlike() {
        // Black and white squares of one pixel, and their negative: the covariance is minus the variance.
        let board = |odd: usize| {
            let pixel = |i: usize| [((i % 40 + i / 40 + odd) % 2) as f32; 3];
            Picture::new([40, 40], (0..1600).map(pixel))
        };
        let got = ssim(&board(0), &board(1));
        // Both means are 0.5, variances 0.25: (-0.5 + C2) / (0.5 + C2), but for the edges.
        assert!((got + 0.996).abs() < 0.03, "{got}");
    }
}
