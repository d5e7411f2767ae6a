//! Which files are needed, and in which order.
use super::unit::Unit;
use super::{ComposeError, File, Problem};
use std::collections::HashMap;

/// Reads `root` and what it imports. Each file comes once, behind everything that it imports; `root` is the last.
pub(super) fn order<'a>(
    root: &File<'a>,
    modules: &[File<'a>],
    features: &[&str],
) -> Result<Vec<Unit<'a>>, ComposeError> {
    let mut search = Search {
        modules,
        features,
        units: Vec::new(),
        done: HashMap::new(),
        open: Vec::new(),
    };
    // No import reaches the root, so a module may have its name.
    search.visit(&File {
        path: "",
        ..root.clone()
    })?;
    Ok(search.units)
}

struct Search<'a, 'm> {
    modules: &'m [File<'a>],
    features: &'m [&'m str],
    units: Vec<Unit<'a>>,
    /// Path of a module to its index in `units`.
    done: HashMap<&'a str, usize>,
    /// Files whose imports are being read, by path and name.
    open: Vec<(&'a str, String)>,
}

impl<'a, 'm> Search<'a, 'm> {
    fn visit(&mut self, file: &File<'a>) -> Result<usize, ComposeError> {
        let unit = Unit::read(file.clone(), self.features)?;
        self.open.push((file.path, file.name.to_string()));
        for import in unit.imports() {
            let module = self.module(file, &import.module, import.name.text, import.name.start)?;
            if let Some(from) = self.open.iter().position(|(path, _)| *path == module.path) {
                let mut circle: Vec<String> = self.open[from..]
                    .iter()
                    .map(|(_, name)| name.clone())
                    .collect();
                circle.push(module.name.to_string());
                return Err(file.error(import.name.start, Problem::Cycle(circle)));
            }
            let index = match self.done.get(module.path) {
                Some(&index) => index,
                None => self.visit(module)?,
            };
            let found = &self.units[index];
            if !found.declared().any(|name| name.text == import.name.text) {
                let problem = Problem::UnknownName {
                    module: import.module.clone(),
                    name: import.name.text.into(),
                    declared: found.declared().map(|name| name.text.into()).collect(),
                };
                return Err(file.error(import.name.start, problem));
            }
        }
        self.open.pop();
        self.units.push(unit);
        self.done.insert(file.path, self.units.len() - 1);
        Ok(self.units.len() - 1)
    }

    fn module(
        &self,
        file: &File<'_>,
        path: &str,
        name: &str,
        at: usize,
    ) -> Result<&'m File<'a>, ComposeError> {
        let find = |path: &str| self.modules.iter().find(|m| m.path == path);
        let problem = match find(path) {
            Some(module) => return Ok(module),
            None if find(&format!("{path}::{name}")).is_some() => {
                Problem::Module(format!("{path}::{name}"))
            }
            None => Problem::UnknownModule {
                path: path.into(),
                known: self.modules.iter().map(|m| m.path.into()).collect(),
            },
        };
        Err(file.error(at, problem))
    }
}
