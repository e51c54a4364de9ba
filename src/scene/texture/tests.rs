use super::{Mapping, Role, Texture, Wrap};
use crate::scene::picture::Picture;
use glam::Vec2;

fn checks(wrap: Wrap) -> Texture {
    let pixel = |i: usize| if (i + i / 2).is_multiple_of(2) { [1.0; 4] } else { [0.0, 0.5, 0.0, 1.0] };
    Texture::new("checks", [2, 2], (0..4).map(pixel).collect(), wrap)
}

/// Red rises to the right and green upwards, in 8-bit steps.
fn ramp(size: [usize; 2]) -> Picture {
    let texel = |i: usize| {
        let (x, row) = (i % size[0], i / size[0]);
        [(x * 255 / (size[0] - 1)) as u8, ((size[1] - 1 - row) * 255 / (size[1] - 1)) as u8, 128, 255]
    };
    Picture { size, texels: (0..size[0] * size[1]).map(texel).collect(), has_alpha: false }
}

#[test]
fn texels_lie_at_their_centres_and_far_away_the_mean_is_seen() {
    let texture = checks(Wrap::Repeat);
    assert_eq!(texture.sample(Vec2::new(0.25, 0.75), 0.0), [1.0; 4]);
    assert_eq!(texture.sample(Vec2::new(0.25, 0.25), 0.0), [0.0, 0.5, 0.0, 1.0]);
    assert_eq!(texture.sample(Vec2::new(-0.75, 5.75), 0.5), [1.0; 4]);
    let mean = [0.5, 0.75, 0.5, 1.0];
    assert_eq!(texture.sample(Vec2::new(0.5, 0.5), 0.0), mean);
    assert_eq!(texture.sample(Vec2::new(0.1, 0.9), 1.0), mean);
    assert_eq!(texture.sample(Vec2::new(0.1, 0.9), f32::INFINITY), mean);
    // Over the edge, the picture goes on or begins again.
    assert_eq!(texture.sample(Vec2::new(0.0, 0.75), 0.0), mean);
    assert_eq!(checks(Wrap::Clamp).sample(Vec2::new(0.0, 0.75), 0.0), [1.0; 4]);
    assert_eq!(checks(Wrap::Clamp).sample(Vec2::new(-3.0, 9.0), 0.0), [1.0; 4]);
}

#[test]
fn bad_coordinates_give_a_colour_of_the_picture() {
    for wrap in [Wrap::Repeat, Wrap::Clamp] {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.0e38, -1.0e-38] {
            for value in checks(wrap).sample(Vec2::new(bad, 0.9), bad) {
                assert!((0.0..=1.0).contains(&value), "{bad}: {value}");
            }
        }
    }
}

#[test]
fn the_footprint_chooses_the_version_whose_texels_are_as_wide() {
    let pixels = vec![[0.5; 4]; 64 * 16];
    let texture = Texture::new("grey", [64, 16], pixels, Wrap::Repeat);
    assert_eq!((texture.levels.len(), texture.density), (7, 32.0));
    for (footprint, level) in [(0.0, 0.0), (1.0 / 64.0, 0.0), (1.0 / 32.0, 0.0), (0.25, 3.0), (100.0, 6.0)] {
        assert_eq!(texture.level(footprint), level, "{footprint}");
    }
    assert!((texture.level(0.354) - 3.5).abs() < 0.01);
    // Repeated twice in each direction, its texels are half as wide.
    let picture = ramp([64, 16]);
    let twice = Mapping { scale: Vec2::splat(2.0), ..Mapping::IDENTITY };
    let repeated = Texture::of_picture("ramp".into(), &picture, Role::Color, twice);
    assert_eq!(repeated.level(0.25), 4.0);
    assert_eq!(repeated.sample(Vec2::splat(0.625), 0.0), repeated.sample(Vec2::splat(0.125), 0.0));
}

#[test]
fn between_texels_values_are_linear_and_v_runs_up() {
    let texture = Texture::of_picture("ramp".into(), &ramp([18, 18]), Role::Height, Mapping::IDENTITY);
    let at = |u: f32, v: f32| texture.sample(Vec2::new(u, v), 0.0)[0];
    // The brightness is (255 (x + y) / 17 + 128) / 765 at texel (x, y) from the lower left corner.
    for (x, y) in [(3.0, 5.0), (3.5, 5.0), (8.25, 10.75), (0.0, 17.0)] {
        let want = (15.0 * (x + y) + 128.0) / 765.0;
        let got = at((x + 0.5) / 18.0, (y + 0.5) / 18.0);
        assert!((got - want).abs() < 4.0e-5, "({x}, {y}): {got}, not {want}");
    }
}

#[test]
fn roles_give_colours_opacities_heights_and_normals() {
    let one = |texel: [u8; 4], has_alpha: bool, role: Role| {
        let picture = Picture { size: [1, 1], texels: vec![texel], has_alpha };
        Texture::of_picture("one".into(), &picture, role, Mapping::IDENTITY).sample(Vec2::ZERO, 0.0)
    };
    let near = |got: [f32; 4], want: [f32; 4]| {
        assert!(got.iter().zip(want).all(|(g, w)| (g - w).abs() < 4.0e-5), "{got:?}, not {want:?}");
    };
    // 188 is the middle of linear light, 0.5029.
    near(one([188, 0, 255, 51], true, Role::Color), [0.50289, 0.0, 1.0, 0.2]);
    near(one([255, 255, 255, 51], true, Role::Opacity), [0.2; 4]);
    near(one([51, 51, 51, 255], false, Role::Opacity), [0.2; 4]);
    near(one([0, 102, 51, 255], false, Role::Height), [0.2, 0.2, 0.2, 1.0]);
    near(one([255, 1, 192, 255], false, Role::Normal), [1.0, 0.0, 0.75197, 1.0]);
    // Flat is exactly flat.
    assert_eq!(one([128, 128, 255, 255], false, Role::Normal), [0.5, 0.5, 1.0, 1.0]);
}

#[test]
fn ranges_and_bytes_are_told() {
    let texture = Texture::of_picture("ramp".into(), &ramp([16, 4]), Role::Color, Mapping::IDENTITY);
    assert_eq!(texture.range(), [0.0, 1.0]);
    assert_eq!(texture.size(), [16, 4]);
    assert_eq!(texture.bytes(), 8 * (64 + 16 + 4 + 2 + 1));
}
