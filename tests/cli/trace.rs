//! `irt trace`.

use super::folder_with_scenes;
use std::fs;

/// A .npy file of version 1 with this header and data.
fn npy(header: &str, data: &[u8]) -> Vec<u8> {
    let mut header = header.to_string();
    header += &" ".repeat(63 - (10 + header.len()) % 64);
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend_from_slice(&u16::try_from(header.len()).unwrap().to_le_bytes());
    bytes.extend_from_slice(header.as_bytes());
    bytes.extend_from_slice(data);
    bytes
}

fn dictionary(dtype: &str, fortran: &str, shape: &str) -> String {
    format!("{{'descr': {dtype}, 'fortran_order': {fortran}, 'shape': ({shape}), }}")
}

fn floats(rays: &[[f32; 8]]) -> Vec<u8> {
    rays.iter().flatten().flat_map(|x| x.to_le_bytes()).collect()
}

const FAR: f32 = f32::INFINITY;

/// Onto the square in the plane z = 0, beside it, away from it, up to before it; then rays that hit nothing at all.
const RAYS: [[f32; 8]; 6] = [
    [0.75, 0.25, 2.0, 0.0, 0.0, 0.0, -1.0, FAR],
    [1.5, 0.5, 2.0, 0.0, 0.0, 0.0, -1.0, FAR],
    [0.5, 0.25, 2.0, 0.0, 0.0, 0.0, 1.0, FAR],
    [0.5, 0.25, 2.0, 0.0, 0.0, 0.0, -1.0, 1.5],
    [0.5, 0.25, 2.0, 0.0, 0.0, 0.0, 0.0, FAR],
    [f32::NAN, 0.25, 2.0, 0.0, 0.0, 0.0, -1.0, FAR],
];

fn good() -> Vec<u8> {
    npy(&dictionary("'<f4'", "False", "6, 8"), &floats(&RAYS))
}

/// Header and data of a .npy file.
fn split(bytes: &[u8]) -> (String, Vec<u8>) {
    assert!(bytes.starts_with(b"\x93NUMPY"));
    let end = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    assert_eq!(end % 64, 0, "data are aligned");
    (String::from_utf8(bytes[10..end].to_vec()).unwrap(), bytes[end..].to_vec())
}

#[test]
fn trace_writes_hits_as_documented() {
    let folder = folder_with_scenes();
    fs::write(folder.path().join("rays.npy"), good()).unwrap();
    let told = folder.run("trace square.toml --rays rays.npy --hits hits.npy --threads 2 --no-pin");
    assert!(told.starts_with("6 rays, 1 hits, ") && told.contains("hits.npy"), "{told}");
    let (header, data) = split(&fs::read(folder.path().join("hits.npy")).unwrap());
    assert!(header.contains("('prim', '<u4'), ('t', '<f4'), ('u', '<f4'), ('v', '<f4')"), "{header}");
    assert!(header.contains("'shape': (6,") && header.contains("'fortran_order': False"), "{header}");
    assert_eq!(data.len(), 6 * 16);
    let number = |at: usize| u32::from_le_bytes(data[at..at + 4].try_into().unwrap());
    assert_eq!([number(0), number(4)], [0, 2.0f32.to_bits()]);
    // (0.75, 0.25) = 0.25 (0, 0) + 0.5 (1, 0) + 0.25 (1, 1)
    assert_eq!([number(8), number(12)].map(f32::from_bits), [0.5, 0.25]);
    for ray in 1..6 {
        assert_eq!([number(16 * ray), number(16 * ray + 4)], [u32::MAX, FAR.to_bits()], "ray {ray}");
    }

    let line = "trace square.toml --rays rays.npy --hits blocked.npy --occluded --isa scalar -q";
    assert_eq!(folder.run(line), "");
    let (header, data) = split(&fs::read(folder.path().join("blocked.npy")).unwrap());
    assert!(header.contains("'|u1'") && header.contains("'shape': (6,"), "{header}");
    assert_eq!(data, [1, 0, 0, 0, 0, 0]);
}

#[test]
fn no_rays_give_no_hits() {
    let folder = folder_with_scenes();
    fs::write(folder.path().join("rays.npy"), npy(&dictionary("'<f4'", "False", "0, 8"), &[])).unwrap();
    folder.run("trace square.toml --rays rays.npy --hits hits.npy");
    let (header, data) = split(&fs::read(folder.path().join("hits.npy")).unwrap());
    assert!(header.contains("'shape': (0,") && data.is_empty(), "{header}");
}

#[test]
fn each_bad_file_of_rays_is_answered_with_one_sentence() {
    let folder = folder_with_scenes();
    let data = floats(&RAYS);
    let array = |dtype: &str, fortran: &str, shape: &str| npy(&dictionary(dtype, fortran, shape), &data);
    let before = folder.names();
    for (bytes, expected) in [
        (array("'<f8'", "False", "3, 8"), "holds values of type '<f8', not little-endian float32"),
        (array("'>f4'", "False", "6, 8"), "holds values of type '>f4'"),
        (array("[('a', '<f4')]", "False", "6, 8"), "holds values of type [('a', '<f4')"),
        (array("'<f4'", "False", "8, 6"), "has the shape (8, 6), not (N, 8)"),
        (array("'<f4'", "False", "48,"), "has the shape (48), not (N, 8)"),
        (array("'<f4'", "False", "1, 6, 8"), "has the shape (1, 6, 8), not (N, 8)"),
        (array("'<f4'", "True", "6, 8"), "is in Fortran order"),
        (array("'<f4'", "False", "7, 8"), "ends before its 7 rays are complete"),
        (array("'<f4'", "False", "99999999999, 8"), "ends before its 99999999999 rays are complete"),
        (array("'<f4'", "False", "5, 8"), "goes on after its 5 rays"),
        (npy("{'descr': '<f4', }", &data), "is no array of NumPy"),
        (npy("nonsense", &data), "is no array of NumPy"),
        (b"\x93NUMPY\x09\x00\x00\x00".to_vec(), "is no array of NumPy"),
        (good()[..20].to_vec(), "is no array of NumPy"),
        (b"v 0 0 0\n".to_vec(), "is no array of NumPy"),
        (Vec::new(), "is no array of NumPy"),
    ] {
        let path = folder.path().join("rays.npy");
        fs::write(&path, bytes).unwrap();
        let message = folder.fail("trace square.toml --rays rays.npy --hits hits.npy", 2);
        assert!(message.starts_with(&format!("rays.npy: {expected}")), "{expected}: {message}");
        fs::remove_file(path).unwrap();
        assert_eq!(folder.names(), before, "{expected}: nothing is left behind");
    }
}

#[test]
fn bad_names_are_answered_before_the_work() {
    let folder = folder_with_scenes();
    fs::write(folder.path().join("rays.npy"), good()).unwrap();
    for (flags, named) in [
        ("--rays none.npy --hits hits.npy", "none.npy"),
        ("--rays . --hits hits.npy", "."),
        ("--rays rays.npy --hits no/hits.npy", "no/hits.npy"),
        ("--rays rays.npy --hits rays.npy", "--hits"),
        ("--rays rays.npy --hits hits.npy --threads 0", "--threads"),
        ("--hits hits.npy", "--rays"),
        ("--rays rays.npy", "--hits"),
    ] {
        let message = folder.fail(&format!("trace square.toml {flags}"), 2);
        assert!(message.starts_with(&format!("{named}: ")), "{flags}: {message}");
    }
    let message = folder.fail("trace none.toml --rays rays.npy --hits hits.npy", 2);
    assert!(message.contains("none.toml"), "{message}");
    assert!(!folder.path().join("hits.npy").exists());
    assert_eq!(fs::read(folder.path().join("rays.npy")).unwrap(), good());
}
