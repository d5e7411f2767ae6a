//! A scene and a view as the program's commands take them.
use gibs::passes::scene::Scene;
use gibs::view::View;
use gibs::{builtin, gltf_import};
use std::error::Error;
use std::path::Path;

/// A built-in scene of that name or the file at that path, with the view in a file or else the scene's own.
///
/// # Errors
/// What is wrong with either file.
pub fn load(scene: &str, view: Option<&Path>) -> Result<(Scene, View), Box<dyn Error>> {
    let (scene, own_view) = match builtin::by_name(scene) {
        Some((scene, view)) => (scene, Some(view)),
        None => (gltf_import::load(Path::new(scene))?.scene, None),
    };
    let view = match (view, own_view) {
        (Some(path), _) => View::load(path)?,
        (None, own) => own.unwrap_or_else(|| View::framing(&scene)),
    };
    Ok((scene, view))
}
