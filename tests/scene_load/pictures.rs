//! Pictures: what decodes to what, and what each kind of bad file gives.

use super::{TRIANGLE, fails, good, load_path, warns, write};
use crate::support::Random;
use glam::Vec2;
use image::{ExtendedColorType, ImageEncoder, Rgb};
use irt::scene::{Scene, Sky, Texture};
use std::{fs, path::Path};
use tempfile::TempDir;

/// A folder with a mesh `a.obj` whose material `m` has `map` of the MTL file, in line 3.
pub(super) fn with_map(map: &str) -> TempDir {
    let folder = TempDir::new().expect("a temporary folder");
    let mesh = format!("mtllib a.mtl\n{TRIANGLE}vt 0 0\nvt 1 0\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3\n");
    write(&folder, "a.obj", mesh.as_bytes());
    write(&folder, "a.mtl", format!("newmtl m\nKd 1 1 1\n{map}\n").as_bytes());
    folder
}

fn load_obj(folder: &TempDir) -> Result<Scene, String> {
    load_path(&folder.path().join("a.obj"))
}

pub(super) fn png(path: &Path, size: [u32; 2], color: ExtendedColorType, bytes: &[u8]) {
    let file = fs::File::create(path).expect("a file");
    let encoder = image::codecs::png::PngEncoder::new(file);
    encoder.write_image(bytes, size[0], size[1], color).expect("a PNG");
}

fn stored(name: &str) -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scene_load/pictures").join(name);
    fs::read(path).expect("a stored picture")
}

/// A texture of these bytes.
fn texture(bytes: &[u8]) -> Result<Texture, String> {
    let folder = with_map("map_Kd t.dat");
    write(&folder, "t.dat", bytes);
    Ok(load_obj(&folder)?.textures.remove(0))
}

/// The 8-bit colour in the middle of the texel in column x and row y from the top.
fn srgb(texture: &Texture, x: u32, y: u32) -> [u8; 3] {
    let [width, height] = texture.size().map(|side| side as f32);
    let uv = Vec2::new((x as f32 + 0.5) / width, 1.0 - (y as f32 + 0.5) / height);
    let [r, g, b, a] = texture.sample(uv, 0.0);
    assert_eq!(a, 1.0);
    [r, g, b].map(irt::math::linear_to_srgb8)
}

#[test]
fn png_of_every_colour_type_is_decoded_exactly() {
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("x.png");
    let decode = |color, bytes: &[u8]| {
        png(&path, [2, 1], color, bytes);
        texture(&fs::read(&path).expect("written")).expect("a texture")
    };
    let rgb = decode(ExtendedColorType::Rgb8, &[1, 2, 3, 250, 128, 9]);
    assert_eq!((rgb.size(), srgb(&rgb, 0, 0), srgb(&rgb, 1, 0)), ([2, 1], [1, 2, 3], [250, 128, 9]));
    let grey = decode(ExtendedColorType::L8, &[77, 200]);
    assert_eq!((srgb(&grey, 0, 0), srgb(&grey, 1, 0)), ([77; 3], [200; 3]));
    let deep = decode(ExtendedColorType::L16, &[0x80, 0x80, 0x12, 0x80]);
    // 16 bits, in the byte order of this machine, keep their upper half.
    let upper = |pair: [u8; 2]| (u16::from_ne_bytes(pair) >> 8) as u8;
    assert_eq!([srgb(&deep, 0, 0)[0], srgb(&deep, 1, 0)[0]], [upper([0x80, 0x80]), upper([0x12, 0x80])]);
    let alpha = decode(ExtendedColorType::La8, &[10, 51, 20, 255]);
    let opacity = alpha.sample(Vec2::new(0.25, 0.5), 0.0)[3];
    assert!((opacity - 0.2).abs() < 2.0e-5, "{opacity}");
}

#[test]
fn jpeg_baseline_progressive_and_grey_are_decoded() {
    // Quadrants of 16 x 12 pixels; JPEG is not exact.
    let colors = [[200, 40, 40], [40, 180, 60], [40, 60, 200], [230, 220, 80]];
    for (name, tolerance) in [("baseline.jpg", 4), ("progressive.jpg", 12)] {
        let texture = texture(&stored(name)).expect(name);
        assert_eq!(texture.size(), [32, 24]);
        for (quadrant, color) in colors.into_iter().enumerate() {
            let [x, y] = [8 + 16 * (quadrant as u32 % 2), 6 + 12 * (quadrant as u32 / 2)];
            let got = srgb(&texture, x, y);
            let off = got.iter().zip(color).map(|(&a, b): (&u8, i32)| (i32::from(a) - b).abs()).max();
            assert!(off <= Some(tolerance), "{name} at ({x}, {y}): {got:?}, not {color:?}");
        }
    }
    let [r, g, b] = srgb(&texture(&stored("grey.jpg")).expect("grey"), 8, 6);
    // 0.299 200 + 0.587 40 + 0.114 40
    assert!(r == g && g == b && (i32::from(r) - 88).abs() <= 3, "{r} {g} {b}");
}

#[test]
fn bad_textures_are_errors_that_name_the_line() {
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("x.png");
    png(&path, [4, 4], ExtendedColorType::Rgb8, &[7; 48]);
    let good_png = fs::read(&path).expect("written");
    let mut bad_end = good_png.clone();
    bad_end[good_png.len() - 1] ^= 1;
    let place = "a.mtl:3: texture `t.dat`";
    let cases: &[(&[u8], &str)] = &[
        (b"", "is no PNG or JPEG picture; save it as PNG or JPEG"),
        (b"BM this is something else", "is no PNG or JPEG picture"),
        (b"#?RADIANCE\n", "is a high-dynamic-range picture, not a texture"),
        (&good_png[..20], "is a broken PNG"),
        (&good_png[..good_png.len() - 14], "is a broken PNG"),
        // All of the picture is there, but not the end of the file.
        (&good_png[..good_png.len() - 12], "is a broken PNG"),
        (&bad_end, "is a broken PNG"),
        (b"\xff\xd8\xff\xe0", "is a broken JPEG"),
    ];
    for &(bytes, what) in cases {
        fails(texture(bytes).map(|_| Scene::default()), &[place, what, "; "]);
    }
    let jpeg = stored("baseline.jpg");
    fails(texture(&jpeg[..jpeg.len() / 2]).map(|_| Scene::default()), &[place, "is a broken JPEG"]);
    // 20000 x 20000 pixels, as the header has it: no memory is spent on them.
    for (side, remedy) in [(20_000u32, "16384 a side"), (16_384, "16384 a side and 67108864 in all")] {
        let mut large = good_png.clone();
        large[16..20].copy_from_slice(&side.to_be_bytes());
        large[20..24].copy_from_slice(&side.to_be_bytes());
        let checksum = crc(&large[12..29]).to_be_bytes();
        large[29..33].copy_from_slice(&checksum);
        let what = format!("has {side}x{side} pixels, which is too large; scale it to at most {remedy}");
        fails(texture(&large).map(|_| Scene::default()), &[place, &what]);
    }
    fails(load_obj(&with_map("map_Kd no such.png")), &["a.mtl:3: texture `no such.png` was not found in "]);
    fails(load_obj(&with_map("map_Kd -s 1 2")), &["a.mtl:3: texture `2` was not found"]);
    fails(load_obj(&with_map("map_d")), &["a.mtl:3: `map_d` without a file"]);
    let is_folder = with_map("map_Ke t");
    fs::create_dir(is_folder.path().join("t")).expect("a folder");
    fails(load_obj(&is_folder), &["a.mtl:3: texture `t` was not found"]);
}

/// Checksum of a PNG chunk.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |c, _| if c & 1 != 0 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 })
    })
}

#[test]
fn damaged_pictures_never_panic() {
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("x.png");
    png(&path, [9, 7], ExtendedColorType::Rgb8, &(0..189).collect::<Vec<u8>>());
    let mut random = Random(91);
    let mut refused = 0;
    let pictures = [
        ("map_Kd t.dat", fs::read(&path).expect("written")),
        ("map_Kd t.dat", stored("baseline.jpg")),
        ("map_Kd t.dat", stored("progressive.jpg")),
    ];
    for (map, bytes) in pictures {
        let folder = with_map(map);
        for _ in 0..150 {
            refused += usize::from(damaged(&mut random, &folder, "t.dat", &bytes, "a.obj").is_err());
        }
    }
    for bytes in [radiance(), open_exr(1.0)] {
        let folder = sky_folder();
        for _ in 0..150 {
            refused += usize::from(damaged(&mut random, &folder, "sky.dat", &bytes, "s.toml").is_err());
        }
    }
    assert!(refused > 200, "{refused}");
}

/// Loads `scene` with the picture made worse in one of several ways.
fn damaged(
    random: &mut Random,
    folder: &TempDir,
    name: &str,
    bytes: &[u8],
    scene: &str,
) -> Result<Scene, String> {
    let mut bytes = bytes.to_vec();
    match random.below(3) {
        0 => bytes.truncate(random.below(bytes.len())),
        1 => {
            let at = random.below(bytes.len());
            bytes[at] ^= 1 << random.below(8);
        }
        _ => {
            for _ in 0..8 {
                let at = random.below(bytes.len());
                bytes[at] = random.bits() as u8;
            }
        }
    }
    write(folder, name, &bytes);
    load_path(&folder.path().join(scene))
}

/// A scene `s.toml` under the sky `sky.dat`, which line 4 names.
fn sky_folder() -> TempDir {
    let folder = with_map("");
    let text = "[[mesh]]\nfile = \"a.obj\"\n[environment]\nmap = \"sky.dat\"\nrotation = 450\nstrength = 2\n";
    write(&folder, "s.toml", text.as_bytes());
    folder
}

fn under(sky: &[u8]) -> Result<Scene, String> {
    let folder = sky_folder();
    write(&folder, "sky.dat", sky);
    load_path(&folder.path().join("s.toml"))
}

fn radiance() -> Vec<u8> {
    let pixels = [[0.0, 0.0, 0.0], [1.0, 0.5, 0.25], [100.0, 0.0, 3.0], [2.0, 2.0, 2.0]].map(Rgb);
    let mut bytes = Vec::new();
    image::codecs::hdr::HdrEncoder::new(&mut bytes).encode(&pixels, 2, 2).expect("a Radiance picture");
    bytes
}

fn open_exr(first: f32) -> Vec<u8> {
    let values = [first, -0.5, 0.25, 1.0e4, 0.0, 3.0];
    let bytes: Vec<u8> = values.into_iter().flat_map(f32::to_ne_bytes).collect();
    let mut file = std::io::Cursor::new(Vec::new());
    image::codecs::openexr::OpenExrEncoder::new(&mut file)
        .write_image(&bytes, 2, 1, ExtendedColorType::Rgb32F)
        .expect("an OpenEXR picture");
    file.into_inner()
}

#[test]
fn skies_are_read_from_radiance_open_exr_and_png() {
    let map = |scene: &Scene| match &scene.environment.sky {
        Sky::Map(map) => map.clone(),
        other => panic!("{other:?}"),
    };
    let scene = good(under(&radiance()));
    let sky = map(&scene);
    assert!(scene.environment.light && scene.lights.is_empty());
    assert_eq!((sky.size, sky.strength, sky.rotation), ([2, 2], 2.0, std::f32::consts::FRAC_PI_2));
    assert_eq!(sky.pixels[..2], [[0.0; 3], [1.0, 0.5, 0.25]]);
    assert!((sky.pixels[2][0] - 100.0).abs() < 0.5 && (sky.pixels[2][2] - 3.0).abs() < 0.5);
    let scene = good(under(&open_exr(7.0)));
    assert_eq!(map(&scene).pixels, [[7.0, 0.0, 0.25], [1.0e4, 0.0, 3.0]]);
    warns(&scene, "sky.dat: negative values of light taken for 0: 1");
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("x.png");
    png(&path, [1, 1], ExtendedColorType::Rgb8, &[255, 0, 188]);
    let [[r, g, b]] = map(&good(under(&fs::read(&path).expect("written")))).pixels[..] else { panic!() };
    assert!((r, g) == (1.0, 0.0) && (b - 0.50289).abs() < 1.0e-5);
}

#[test]
fn bad_skies_are_errors_with_line_and_column() {
    let place = "s.toml:4: column 7: environment `sky.dat` ";
    for (bytes, what) in [
        (b"nothing".to_vec(), "is no Radiance, OpenEXR, PNG or JPEG picture; save it as .hdr or .exr"),
        (open_exr(f32::NAN), "holds a value that is not finite, at pixel (0, 0); repair the picture"),
        (open_exr(f32::INFINITY), "holds a value that is not finite"),
        (open_exr(3.0e38), "times `strength` is too great; lower"),
        (radiance()[..radiance().len() - 3].to_vec(), "is a broken Radiance picture"),
        (open_exr(1.0)[..200].to_vec(), "is a broken OpenEXR picture"),
        (b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 99999 +X 99999\n".to_vec(), "99999x99999 pixels"),
    ] {
        fails(under(&bytes), &[place, what]);
    }
    fails(load_path(&sky_folder().path().join("s.toml")), &["environment `sky.dat` was not found in "]);
}
