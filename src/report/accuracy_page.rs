//! The page of `irt accuracy`: one HTML file with everything in it.

use super::{
    Curve, Curves, Mark, Table,
    accuracy::{geometry_table, mode_table, omitted_table},
    html::{escaped, picture},
};
use crate::{
    error::Result,
    film::Film,
    study::accuracy::{Knob, Mode, Row, SceneAccuracy, heat, heat_color, verdict},
    tile::Tile,
};

/// The page.
///
/// # Errors
/// [`crate::error::Error::Failed`] if a plot or a picture cannot be drawn.
pub fn accuracy_page(scenes: &[SceneAccuracy]) -> Result<String> {
    let links = scenes.iter().enumerate();
    let links: String =
        links.map(|(i, s)| format!("<a href=\"#scene{i}\">{}</a> ", escaped(&s.scene))).collect();
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <title>What accuracy costs</title>\n<style>{STYLE}</style>\n</head>\n<body>\n\
         <h1>What accuracy costs</h1>\n<p class=\"lead\">{LEAD}</p>\n<nav>{links}</nav>\n"
    );
    for (i, scene) in scenes.iter().enumerate() {
        page += &section(i, scene)?;
    }
    page += DEFINITIONS;
    page += "</body>\n</html>\n";
    Ok(page)
}

fn section(index: usize, scene: &SceneAccuracy) -> Result<String> {
    let one = std::slice::from_ref(scene);
    let [width, height] = scene.size;
    let facts = format!(
        "{} triangles, {width}x{height} pixels, {} threads, {}; converged image: {} samples per pixel, its noise RMSE {:.2e}",
        super::count(scene.triangles as u64),
        scene.threads,
        scene.isa,
        scene.converged,
        scene.noise
    );
    let mut text =
        format!("<section id=\"scene{index}\">\n<h2>{}</h2>\n<p>{facts}</p>\n", escaped(&scene.scene));
    text += "<div class=\"two\">\n";
    text += &picture(&film(scene), "default image")?;
    text += &format!("<div><h3>Verdicts</h3>\n{}</div>\n</div>\n", verdicts(scene));
    text += "<h3>Error against time</h3>\n<div class=\"plots\">\n";
    text += &curves(scene, "RMSE", |row| row.error.rmse, Some(scene.noise)).to_svg()?;
    text += &curves(scene, "FLIP", |row| row.error.flip, None).to_svg()?;
    text += "</div>\n<h3>Times</h3>\n<p>A frame of each mode over the default frame beside it: median, and where the true \
             median lies. The upright line is 1.</p>\n";
    text += &intervals(scene);
    text += &titled("Modes", &mode_table(one));
    text +=
        &titled("Hits and shadows against the f64 reference, leaks of closed meshes", &geometry_table(one));
    text += &titled("Left out", &omitted_table(one));
    text += &maps(scene)?;
    Ok(text + "</section>\n")
}

fn titled(title: &str, table: &Table) -> String {
    if table.rows().is_empty() {
        return String::new();
    }
    format!("<h3>{}</h3>\n<div class=\"wide\">{}</div>\n", escaped(title), table.to_html())
}

fn film(scene: &SceneAccuracy) -> Film {
    let [width, height] = scene.picture.size();
    let plane = |c: usize| -> Vec<f32> { scene.picture.pixels().iter().map(|pixel| pixel[c]).collect() };
    let film = Film::new(width, height);
    film.write_tile(Tile { x: 0, y: 0, width, height }, &plane(0), &plane(1), &plane(2));
    film
}

fn verdicts(scene: &SceneAccuracy) -> String {
    let item = |row: &Row| {
        let text = verdict(scene, row);
        let (name, rest) = text.split_once(": ").unwrap_or(("", &text));
        let class = if row.front { " class=\"front\"" } else { "" };
        format!("<li{class}><b>{}</b>: {}</li>\n", escaped(name), escaped(rest))
    };
    let items: String = scene.rows.iter().map(item).collect();
    format!(
        "<ul class=\"verdicts\">\n{items}</ul>\n<p>Marked: no other mode is both quicker and nearer to the converged image.</p>\n"
    )
}

/// Curves of the sampling knobs, dots for the others, and the front.
fn curves(scene: &SceneAccuracy, measure: &str, error: impl Fn(&Row) -> f64, noise: Option<f64>) -> Curves {
    let default = scene.rows.iter().find(|row| row.mode == Mode::Default);
    // By the ratio to the default frames beside them: whatever slows the machine down for a while does not count.
    let usual = 1e3 * default.map_or(1.0, |row| row.times.seconds.median / row.times.ratio.median);
    let point = |row: &Row, name: String| (usual * row.times.ratio.median, error(row), name);
    let mut curves = vec![];
    for knob in Knob::ALL.into_iter().filter(|knob| knob.converges() || *knob == Knob::Depth) {
        let of_knob: Vec<&Row> = scene.rows.iter().filter(|row| row.mode.knob() == Some(knob)).collect();
        let mut points: Vec<_> = of_knob.iter().map(|row| point(row, short(row))).collect();
        if !points.is_empty() {
            points.extend(default.map(|row| point(row, String::new())));
            // Two numbers make no line.
            let mark = if knob == Knob::Adaptive { Mark::Dots } else { Mark::Line };
            curves.push(Curve { name: knob.name().into(), points, mark });
        }
    }
    curves.extend(default.map(|row| Curve {
        name: "default".into(),
        points: vec![point(row, "default".into())],
        mark: Mark::Dots,
    }));
    let front = scene.rows.iter().filter(|row| row.front).map(|row| point(row, String::new())).collect();
    curves.push(Curve { name: "Pareto front of RMSE".into(), points: front, mark: Mark::Rings });
    Curves {
        title: format!("{}: {measure} against wall time", scene.scene),
        x: "milliseconds of a frame".into(),
        y: format!("{measure} from the converged image"),
        curves,
        level: noise.map(|noise| (noise, "noise of the converged image".into())),
    }
}

/// The setting without the name of its knob.
fn short(row: &Row) -> String {
    if let Mode::Adaptive(count, least) = row.mode {
        return format!("{count}, {least}");
    }
    let name = row.mode.to_string();
    name.rsplit(' ').next().unwrap_or(&name).into()
}

/// Width of a chart of intervals in pixels, for ratios from a quarter to four times.
const WIDE: f64 = 420.0;

fn intervals(scene: &SceneAccuracy) -> String {
    let place = |ratio: f64| (ratio.log2() / 4.0 + 0.5).clamp(0.0, 1.0) * WIDE;
    let line = |row: &Row| {
        let ratio = row.times.ratio;
        let (low, high, median) = (place(ratio.low), place(ratio.high), place(ratio.median));
        format!(
            "<tr><td>{}</td><td><svg width=\"{WIDE}\" height=\"14\"><line x1=\"{one}\" x2=\"{one}\" y1=\"0\" y2=\"14\" \
             stroke=\"#999\"/><line x1=\"{low:.1}\" x2=\"{high:.1}\" y1=\"7\" y2=\"7\" stroke=\"#0072b2\" \
             stroke-width=\"3\"/><circle cx=\"{median:.1}\" cy=\"7\" r=\"4\" fill=\"#0072b2\"/></svg></td>\
             <td class=\"number\">{:.3}</td><td class=\"number\">{:.3} to {:.3}</td></tr>\n",
            escaped(&row.mode.to_string()),
            ratio.median,
            ratio.low,
            ratio.high,
            one = place(1.0),
        )
    };
    let lines: String = scene.rows.iter().map(line).collect();
    format!(
        "<table class=\"intervals\"><thead><tr><th>mode</th><th>0.25 .. 1 .. 4 (logarithmic)</th><th>median</th>\
         <th>interval</th></tr></thead><tbody>\n{lines}</tbody></table>\n"
    )
}

fn maps(scene: &SceneAccuracy) -> Result<String> {
    let stops = [-10.0f32, -8.0, -6.0, -4.0, -2.0, 0.0].map(|log| {
        let [r, g, b] = heat_color(log.exp2() * 1.0001);
        format!("rgb({r},{g},{b})")
    });
    let mut text = format!(
        "<h3>Where they differ</h3>\n<p>Greatest difference of a channel in linear values, logarithmic: \
         <span class=\"scale\" style=\"background:linear-gradient(to right,{})\"></span> from 1/1024 to 1. Sampling, bounces and \
         fill against the converged image, the others against the default image. Modes without a map differ nowhere.</p>\n\
         <div class=\"maps\">\n",
        stops.join(",")
    );
    for row in scene.rows.iter().filter(|row| row.map.iter().any(|&difference| difference > 0.0)) {
        text += &picture(&heat(&row.map, scene.size), &row.mode.to_string())?;
    }
    Ok(text + "</div>\n")
}

const LEAD: &str = "Every approximation that irt offers, one at a time: what it costs or saves in time, measured by turns with \
the default, and what it changes in the image, measured against an image of many samples and a reference in f64.";

const STYLE: &str = "body{font:15px/1.45 system-ui,sans-serif;margin:2em auto;max-width:1240px;padding:0 1em;color:#222}\
h1{margin-bottom:.2em}h2{margin-top:2em;border-bottom:2px solid #0072b2}.lead{max-width:60em;color:#444}\
nav a{margin-right:1em}table{border-collapse:collapse;font-size:13px}\
th,td{padding:2px 8px;border-bottom:1px solid #ddd;text-align:left}th{background:#f3f6f9}\
.number{text-align:right;font-variant-numeric:tabular-nums}.wide{overflow-x:auto}\
.two{display:flex;flex-wrap:wrap;gap:1.5em;align-items:flex-start}.two>div{flex:1;min-width:24em}\
.verdicts{padding-left:1.1em;font-size:14px}.verdicts .front b{background:#fff0b3}\
figure{margin:0}figcaption{font-size:12px;color:#555}img{max-width:100%;image-rendering:pixelated;border:1px solid #ccc}\
.two>figure{flex:0 0 340px}.two img{width:340px}\
.plots svg{max-width:100%;height:auto;border:1px solid #eee;margin:.3em 0}\
.maps{display:grid;grid-template-columns:repeat(auto-fill,minmax(220px,1fr));gap:10px}.maps img{width:100%}\
.scale{display:inline-block;width:160px;height:12px;border:1px solid #999;vertical-align:middle}\
dt{font-weight:600}dd{margin:0 0 .4em 1.5em}";

const DEFINITIONS: &str = "<section><h2>Definitions</h2>\n<dl>\n\
<dt>ratio, from, to</dt><dd>Time of a frame over that of the default frame rendered beside it; the median of the rounds, and an \
interval of order statistics that holds the true median in 99 of 100 cases (with fewer than 8 rounds, all that was seen).</dd>\n\
<dt>RMSE, PSNR, max</dt><dd>Of linear values clamped to [0, 1], all channels, against the converged image.</dd>\n\
<dt>SSIM, FLIP</dt><dd>Wang et al. 2004; Andersson et al. 2020, for a screen 0.7 m away with 67 pixels per degree.</dd>\n\
<dt>ties, errors</dt><dd>Pixels whose first hit is another triangle than the reference's: at the same point, or elsewhere.</dd>\n\
<dt>ulp of t</dt><dd>Error of the depth in units in the last place of f32: median, and the greatest.</dd>\n\
<dt>leaks</dt><dd>Rays aimed at vertices and edges of closed meshes that went through. Zero of n means fewer than 3/n, 95 times of \
100.</dd>\n<dt>noise</dt><dd>RMSE of the converged image's own noise: half of that between its halves, which have seeds of their \
own.</dd>\n</dl>\n</section>\n";
