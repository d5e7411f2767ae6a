//! What reports have in common that are one HTML file each, with everything in it.
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, RgbImage};

/// What a page looks like; light and dark as the reader has it.
const STYLE: &str = "
:root { color-scheme: light dark; font: 15px/1.45 system-ui, sans-serif; }
body { max-width: 76rem; margin: 2rem auto; padding: 0 1rem; }
table { border-collapse: collapse; margin: .6rem 0; }
th, td { text-align: left; padding: .15rem .7rem .15rem 0; vertical-align: top; }
th { font-weight: 600; border-bottom: 1px solid #8888; }
td.n { text-align: right; font-variant-numeric: tabular-nums; }
figure { display: inline-block; margin: .4rem 1rem .4rem 0; }
img { image-rendering: pixelated; border: 1px solid #8888; background: #000; }
figcaption, .why { font-size: .85em; opacity: .8; }
summary { cursor: pointer; padding: .2rem 0; }
code { font-size: .92em; }
";

/// A page with this title, a style of its own beside the common one, and a body.
pub(crate) fn page(title: &str, style: &str, body: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
         <link rel=\"icon\" href=\"data:,\"><title>{}</title><style>{STYLE}{style}</style>{body}</html>\n",
        escaped(title)
    )
}

/// Text without anything that HTML would take for its own.
pub(crate) fn escaped(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;");
    text.replace('>', "&gt;").replace('"', "&quot;")
}

/// A picture as the address of an `img`; `None` where it has no pixels.
pub(crate) fn png(image: &RgbImage) -> Option<String> {
    let mut bytes = Vec::new();
    let written = PngEncoder::new(&mut bytes).write_image(
        image,
        image.width(),
        image.height(),
        ExtendedColorType::Rgb8,
    );
    let text = written.ok().map(|()| BASE64_STANDARD.encode(bytes))?;
    Some(format!("data:image/png;base64,{text}"))
}
