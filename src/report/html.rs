//! Pieces of self-contained HTML pages: text, tables, pictures. The only file that names `base64`.

use super::table::Table;
use crate::{
    error::{Error, Result},
    film::Film,
    math::linear_to_srgb8,
    output::write_bytes,
};
use base64::{Engine, engine::general_purpose::STANDARD};

/// `text` with what HTML would take for its own written otherwise.
pub fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            c => safe.push(c),
        }
    }
    safe
}

impl Table {
    /// The table as HTML, numbers aligned to the right (class `number`).
    pub fn to_html(&self) -> String {
        let head: String =
            self.columns().iter().map(|column| format!("<th>{}</th>", escaped(column))).collect();
        let mut text = format!("<table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n");
        for row in self.rows() {
            let cell = |(i, cell): (usize, &super::Cell)| {
                let class = if self.is_numeric(i) { " class=\"number\"" } else { "" };
                format!("<td{class}>{}</td>", escaped(&cell.readable()))
            };
            let cells: String = row.iter().enumerate().map(cell).collect();
            text += &format!("<tr>{cells}</tr>\n");
        }
        text + "</tbody>\n</table>\n"
    }
}

/// A film as a PNG inside the page.
///
/// # Errors
/// [`Error::Failed`] if it cannot be encoded.
pub fn picture(film: &Film, caption: &str) -> Result<String> {
    let bytes: Vec<u8> = film.pixels().flatten().map(linear_to_srgb8).collect();
    let mut png = vec![];
    write_bytes(&mut png, [film.width(), film.height()], &bytes)
        .map_err(|error| Error::Failed(format!("a picture of the report cannot be encoded ({error})")))?;
    let (data, caption) = (STANDARD.encode(png), escaped(caption));
    Ok(format!(
        "<figure><img alt=\"{caption}\" src=\"data:image/png;base64,{data}\"><figcaption>{caption}</figcaption></figure>\n"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::table::sample;

    #[test]
    fn no_text_becomes_markup() {
        assert_eq!(escaped("a<b> & \"c\""), "a&lt;b&gt; &amp; &quot;c&quot;");
        let html = sample().to_html();
        assert!(html.contains("<td>a &quot;b&quot;, c</td><td class=\"number\">1000000</td>"), "{html}");
        assert_eq!(html.matches("<tr>").count(), 3);
    }

    #[test]
    fn pictures_are_inside_the_page() {
        let html = picture(&Film::new(3, 2), "black").unwrap();
        let data = html.split("base64,").nth(1).unwrap().split('"').next().unwrap();
        let png = STANDARD.decode(data).unwrap();
        assert!(png.starts_with(b"\x89PNG"));
        // Width and height, in the header.
        assert_eq!(png[16..24], [0, 0, 0, 3, 0, 0, 0, 2]);
    }
}
