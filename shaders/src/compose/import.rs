//! Import statements.
use super::token::{Cursor, Token};
use super::{ComposeError, Problem};

/// One imported declaration.
#[derive(Clone, Debug)]
pub(super) struct Import<'a> {
    /// Path of the module, without `package::`.
    pub module: String,
    /// Name of the declaration.
    pub name: Token<'a>,
}

/// How deep lists may nest; bounds the recursion.
const MAX_DEPTH: usize = 16;

/// Reads `package::..;`, after the word `import`.
pub(super) fn read<'a>(cursor: &mut Cursor<'a, '_>) -> Result<Vec<Import<'a>>, ComposeError> {
    let first = cursor.name("`package::`")?;
    if first.text != "package" {
        return Err(cursor
            .file
            .error(first.start, Problem::Foreign(first.text.into())));
    }
    cursor.expect("::", "`::`")?;
    let mut imports = Vec::new();
    tree(cursor, &mut Vec::new(), &mut imports, 0)?;
    cursor.expect(";", "`::` or `;`")?;
    Ok(imports)
}

/// Reads what follows a `::`: a path, or a list of them in braces.
fn tree<'a>(
    cursor: &mut Cursor<'a, '_>,
    path: &mut Vec<&'a str>,
    imports: &mut Vec<Import<'a>>,
    depth: usize,
) -> Result<(), ComposeError> {
    let outer = path.len();
    loop {
        if cursor.is("*") {
            return Err(cursor.error_here(Problem::Wildcard));
        }
        if cursor.is("{") {
            if depth == MAX_DEPTH {
                return Err(cursor.unexpected("a list with less nesting"));
            }
            cursor.at += 1;
            while !cursor.is("}") {
                tree(cursor, path, imports, depth + 1)?;
                if !cursor.skip(",") {
                    break;
                }
            }
            cursor.expect("}", "`,` or `}`")?;
            break;
        }
        let name = cursor.name("a name, or names in `{}`")?;
        if cursor.is("as") {
            return Err(cursor.error_here(Problem::Renamed));
        }
        if !cursor.skip("::") {
            if path.is_empty() {
                return Err(cursor
                    .file
                    .error(name.start, Problem::Module(name.text.into())));
            }
            imports.push(Import {
                module: path.join("::"),
                name,
            });
            break;
        }
        path.push(name.text);
    }
    path.truncate(outer);
    Ok(())
}

impl Cursor<'_, '_> {
    fn error_here(&self, problem: Problem) -> ComposeError {
        self.file.error(self.peek().map_or(0, |t| t.start), problem)
    }
}
