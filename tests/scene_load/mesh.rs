//! OBJ and MTL files.

use super::{TRIANGLE, fails, folder, good, load_path, obj, warns, write};
use glam::Vec3;
use std::path::Path;

#[test]
fn malformed_lines_of_an_obj_are_errors_that_name_the_line() {
    for (last, line, what) in [
        ("v 0 0", 4, "a vertex needs three coordinates"),
        ("v 0 nan 0", 4, "`nan` is not a finite 32-bit number"),
        ("v 0 inf 0", 4, "`inf` is not a finite"),
        ("v 0 0 1e39", 4, "`1e39` is not a finite"),
        ("v 0 0 -2e18", 4, "`-2e18` is beyond the range of coordinates, 1e18"),
        ("v 1 1 1 1e-30", 4, "dividing by the weight"),
        ("v 0 0 0,5", 4, "`0,5` is not a number"),
        ("v 1 2 3 0", 4, "dividing by the weight 0"),
        ("vn 0 1", 4, "a normal needs three components"),
        ("vn 0 1 x", 4, "`x` is not a number"),
        ("f 1 2 0", 4, "vertex index 0 is out of range"),
        ("f 1 2 -4", 4, "vertex index -4 is out of range, there are 3"),
        ("f 1 2 4", 4, "vertex index 4 is out of range, the file has 3"),
        ("f 1 2 99999999999999999999", 4, "is not a face corner"),
        ("f 1 2 9223372036854775807", 4, "out of range"),
        ("f 1 2 -9223372036854775808", 4, "out of range"),
        ("f 1//1 2//1 3//1", 4, "normal index 1 is out of range"),
        ("f 1//-1 2//1 3//1", 4, "normal index -1 is out of range"),
        ("f 1 2 x", 4, "`x` is not a face corner"),
        ("f 1 2 3/1/1/1", 4, "`3/1/1/1` is not a face corner"),
        ("f 1 2 /1/1", 4, "`/1/1` is not a face corner"),
        ("# two\n\nf 1 2 \\\n 9", 6, "vertex index 9"),
    ] {
        let place = format!("a.obj:{line}: ");
        fails(obj(&format!("{TRIANGLE}{last}\nf 1 2 3\n"), &[]), &[&place, what, "; "]);
    }
}

#[test]
fn files_without_a_face_or_text_are_errors() {
    fails(obj("", &[]), &["a.obj: holds no mesh"]);
    fails(obj("# only a comment\n", &[]), &["holds no mesh"]);
    fails(obj(TRIANGLE, &[]), &["holds vertices but no face"]);
    fails(obj(&format!("{TRIANGLE}f 1 2 2\n"), &[]), &["only triangles of zero area"]);
    fails(obj("v 0 0 0\n\0", &[]), &["a.obj:2: ", "zero byte"]);
    fails(load_path(Path::new("nowhere/a.obj")), &["nowhere/a.obj: cannot be read", "check the path"]);
    let folder = folder(&[("x.obj/y", "")]);
    fails(load_path(&folder.path().join("x.obj")), &["is not a regular file"]);
    let other = write(&folder, "a.stl", b"solid");
    fails(load_path(&other), &["is of no kind that can be read", ".obj"]);
}

#[test]
fn what_an_obj_may_say_in_many_ways_is_understood() {
    let text = "\u{feff}# head\r\nv 0 0 0 # origin\r\nv 1 0 \\\r\n 0\r\nv 2 2 0 2\n  v 0 1 0 1 0.5 0\n\
                vn 0 0 -2e-30\nvt 0 0\ng left\nf 1/1 2/1/1 -2//-1\nf 1 3 4\ng right side\ns 1\nfo 2//1 3//1 4//1";
    let scene = good(obj(text, &[]));
    assert_eq!(scene.mesh.corners(0), [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0)]);
    assert_eq!(scene.mesh.corners(1), [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0), Vec3::Y]);
    let normal = |prim: usize, k: usize| scene.mesh.normals[scene.mesh.triangles[prim][k] as usize];
    assert_eq!([normal(0, 0), normal(0, 1), normal(0, 2)], [Vec3::ZERO, -Vec3::Z, -Vec3::Z]);
    assert_eq!([normal(1, 0), normal(2, 0)], [Vec3::ZERO, -Vec3::Z]);
    let parts: Vec<_> = scene.mesh.parts.iter().map(|part| (&*part.name, part.first, part.count)).collect();
    assert_eq!(parts, [("left", 0, 2), ("right side", 2, 1)]);
    warns(&scene, "vertex colours ignored: 1 (first in line 6)");
    assert_eq!(scene.warnings.len(), 1, "{:?}", scene.warnings);
}

#[test]
fn polygons_are_cut_properly_and_forward_references_work() {
    let arrow = "f 1 2 3 4\nv 0 0 0\nv 2 2 0\nv 0 1 0\nv -2 2 0\n";
    let scene = good(obj(arrow, &[]));
    let area = |prim| {
        let [a, b, c] = scene.mesh.corners(prim);
        0.5 * (b - a).cross(c - a).z
    };
    assert_eq!((scene.mesh.len(), area(0) + area(1)), (2, 2.0));
    assert!(area(0) > 0.0 && area(1) > 0.0);
    let tie = good(obj("v 0 0 0\nv 2 2 0\nv 2 0 0\nv 0 2 0\nv -1 1 0\nf 1 2 3 4 5\n", &[]));
    warns(&tie, "polygons that cross themselves or have no area cut into a fan: 1");
}

#[test]
fn what_an_obj_asks_in_vain_is_counted() {
    let text = format!(
        "{TRIANGLE}vn nan 0 0\nf 1 2 3\nf 1//1 3 2\nf 1 1 2\nf 1 2\nl 1 2\np 1\ncurv 0 1\ncurv 0 1\n\
         usemtl\nf 2 1 3\nusemtl none\nf 3 2 1\nmtllib gone.mtl\nmtllib\nf 1 2 1\n"
    );
    let scene = good(obj(&text, &[]));
    for warning in [
        "normals that are not finite (flat shading there): 1 (first in line 4)",
        "triangles of exactly zero area dropped: 2",
        "faces with fewer than three corners dropped: 1 (first in line 8)",
        "points and lines dropped: 2 (first in line 9)",
        "unsupported statement `curv` ignored: 2 (first in line 11)",
        "`usemtl` without a name (default material used): 1 (first in line 13)",
        "material `none` not defined (default used): 1 (first in line 15)",
        "material file `gone.mtl` not found: 1 (first in line 17)",
        "`mtllib` without a name: 1 (first in line 18)",
    ] {
        warns(&scene, warning);
    }
    assert_eq!(scene.warnings.len(), 9, "{:?}", scene.warnings);
    assert_eq!((scene.mesh.len(), scene.report().degenerate_dropped), (4, 2));
    assert_eq!(scene.materials.len(), 1);
    assert_eq!(scene.materials[0].name, "default");
}

#[test]
fn a_file_of_garbage_gives_few_warnings() {
    let garbage: String = (0..5000).map(|i| format!("junk{i} 1 2\n")).collect();
    let scene = good(obj(&format!("{TRIANGLE}f 1 2 3\n{garbage}"), &[]));
    assert!(scene.warnings.len() < 50, "{}", scene.warnings.len());
    warns(&scene, ": 4960 (first in line 45)");
}

#[test]
fn materials_come_from_all_files_with_all_their_values() {
    let text = format!(
        "mtllib a.mtl b.mtl\nmtllib with space.mtl\nmtllib C:\\dir\\a.mtl\n{TRIANGLE}\
         usemtl grey#1\nf 1 2 3\nusemtl glass ball\nf 2 3 1\nusemtl spaced\nf 3 1 2\n"
    );
    let a = "Kd 1 1 1\nnewmtl grey#1 # comment\nKd 0.8\nKs .1 .2 .3\nNs 50\nKe 1 2 3\nKa 0.5\nNi 1.5\nd 0.25\nillum 7\n";
    let b = "newmtl glass ball\nKd spectral x.rfl\nTr 0.75\nmap_Ns -s 2 2 1 t.png\nPs 0.5\nillum 99\nNs -3\nNi 0\n\
             newmtl twice\nd 1\nTr 1\nnewmtl grey#1\nKd 0 0 0\nd -halo 0.5\n";
    let files = [("a.mtl", a), ("b.mtl", b), ("with space.mtl", "newmtl spaced\nKd 1.5 -1 \\\n 0\n")];
    let scene = good(obj(&text, &files));
    let of = |prim: usize| &scene.materials[scene.mesh.materials[prim] as usize];
    let grey = of(0);
    assert_eq!(
        (grey.kd, grey.ks, grey.ke),
        (Vec3::splat(0.8), Vec3::new(0.1, 0.2, 0.3), Vec3::new(1.0, 2.0, 3.0))
    );
    assert_eq!((grey.ka, grey.ns, grey.ni, grey.d, grey.illum), (Vec3::splat(0.5), 50.0, 1.5, 0.25, 7));
    let glass = of(1);
    assert_eq!((&*glass.name, glass.kd, glass.d), ("glass ball", Vec3::splat(0.7), 0.25));
    assert_eq!((glass.illum, glass.ns, glass.ni), (2, 0.0, 1.0));
    assert_eq!(of(2).kd, Vec3::new(1.5, 0.0, 0.0));
    for warning in [
        "a.mtl: statements before the first `newmtl` ignored: 1 (first in line 1)",
        "b.mtl: colours given as `spectral` or `xyz` ignored: 1 (first in line 2)",
        "b.mtl: textures of unsupported kinds ignored: 1 (first in line 4)",
        "b.mtl: unsupported statement `Ps` ignored: 1 (first in line 5)",
        "b.mtl: values of `illum` out of range brought into it: 1 (first in line 6)",
        "b.mtl: values of `Ns` out of range brought into it: 1 (first in line 7)",
        "b.mtl: values of `Ni` out of range brought into it: 1 (first in line 8)",
        "b.mtl: materials whose `d` and `Tr` contradict each other (`d` used): 1 (first in line 12)",
        "b.mtl: `-halo` ignored: 1 (first in line 14)",
        "b.mtl: further definitions of material `grey#1` ignored: 1",
        "with space.mtl: values of `Kd` out of range brought into it: 1 (first in line 2)",
    ] {
        warns(&scene, warning);
    }
    assert_eq!(scene.warnings.len(), 11, "{:#?}", scene.warnings);
}

#[test]
fn malformed_lines_of_an_mtl_are_errors_that_name_the_line() {
    for (line, what) in [
        ("Kd 1 1", "`Kd` needs one or three numbers, not 2"),
        ("Kd", "`Kd` needs one or three numbers, not 0"),
        ("Kd x", "`Kd` needs a finite number, not `x`"),
        ("Ke 1 nan 1", "`Ke` needs a finite number, not `nan`"),
        ("Ns", "`Ns` needs a finite number, not ``"),
        ("d opaque", "`d` needs a finite number"),
        ("Tr", "`Tr` needs a finite number"),
        ("newmtl", "`newmtl` without a name"),
    ] {
        let result = obj(
            &format!("mtllib a.mtl\n{TRIANGLE}f 1 2 3\n"),
            &[("a.mtl", &format!("newmtl m\n# c\n{line}\n"))],
        );
        fails(result, &["a.mtl:3: ", what]);
    }
}
