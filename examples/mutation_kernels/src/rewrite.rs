//! Mutants within a source file.
use proc_macro2::Span;
use quote::quote;
use std::collections::BTreeSet;
use syn::visit_mut::{self, VisitMut};
use syn::{
    BinOp, Expr, ExprBinary, ExprCall, ExprIndex, ExprMethodCall, ExprUnary, File, Stmt, UnOp,
};

/// Something that can be changed.
#[derive(Clone, Debug)]
pub struct Found {
    /// What is changed.
    pub what: String,
    /// In which line.
    pub line: usize,
}

/// Which candidates to write; those of a file are numbered from `first` on.
#[derive(Clone, Copy)]
pub struct Chosen<'a> {
    pub first: usize,
    pub chosen: &'a BTreeSet<usize>,
}

/// Everything in a file that can be changed.
pub fn candidates(text: &str) -> Result<Vec<Found>, syn::Error> {
    let nothing = BTreeSet::new();
    let mut file: File = syn::parse_str(text)?;
    let mut writer = Writer::new(Chosen {
        first: 0,
        chosen: &nothing,
    });
    writer.visit_file_mut(&mut file);
    Ok(writer.found)
}

/// The file with the chosen mutants, and how many candidates it has.
pub fn rewrite(text: &str, chosen: Chosen<'_>) -> Result<(String, usize), syn::Error> {
    let mut file: File = syn::parse_str(text)?;
    let mut writer = Writer::new(chosen);
    writer.visit_file_mut(&mut file);
    Ok((prettyplease::unparse(&file), writer.found.len()))
}

struct Writer<'a> {
    chosen: Chosen<'a>,
    found: Vec<Found>,
    /// Within an expression that is written twice, nothing is written.
    within: bool,
}

impl<'a> Writer<'a> {
    fn new(chosen: Chosen<'a>) -> Self {
        Self {
            chosen,
            found: Vec::new(),
            within: false,
        }
    }

    /// The next candidate's number, where it is to be written.
    fn next(&mut self, what: String, line: usize) -> Option<u32> {
        let number = self.chosen.first + self.found.len();
        self.found.push(Found { what, line });
        let written = !self.within && self.chosen.chosen.contains(&number);
        written.then_some(number as u32)
    }
}

fn line(span: Span) -> usize {
    span.start().line
}

fn other(op: &BinOp) -> Option<BinOp> {
    Some(match op {
        BinOp::Add(_) => syn::parse_quote!(-),
        BinOp::Sub(_) => syn::parse_quote!(+),
        BinOp::Mul(_) => syn::parse_quote!(/),
        BinOp::Div(_) => syn::parse_quote!(*),
        BinOp::Rem(_) => syn::parse_quote!(/),
        BinOp::And(_) => syn::parse_quote!(||),
        BinOp::Or(_) => syn::parse_quote!(&&),
        BinOp::BitAnd(_) => syn::parse_quote!(|),
        BinOp::BitOr(_) => syn::parse_quote!(&),
        BinOp::BitXor(_) => syn::parse_quote!(&),
        BinOp::Shl(_) => syn::parse_quote!(>>),
        BinOp::Shr(_) => syn::parse_quote!(<<),
        BinOp::Eq(_) => syn::parse_quote!(!=),
        BinOp::Ne(_) => syn::parse_quote!(==),
        BinOp::Lt(_) => syn::parse_quote!(>=),
        BinOp::Le(_) => syn::parse_quote!(>),
        BinOp::Gt(_) => syn::parse_quote!(<=),
        BinOp::Ge(_) => syn::parse_quote!(<),
        BinOp::AddAssign(_) => syn::parse_quote!(-=),
        BinOp::SubAssign(_) => syn::parse_quote!(+=),
        BinOp::MulAssign(_) => syn::parse_quote!(/=),
        _ => return None,
    })
}

/// Pairs of functions over lanes that take the same and give the same.
const PAIRS: [(&str, &str); 9] = [
    ("_mm256_add_ps", "_mm256_sub_ps"),
    ("_mm256_mul_ps", "_mm256_div_ps"),
    ("_mm256_min_ps", "_mm256_max_ps"),
    ("_mm256_and_ps", "_mm256_or_ps"),
    ("_mm256_xor_ps", "_mm256_and_ps"),
    ("_mm256_add_epi32", "_mm256_sub_epi32"),
    ("_mm256_and_si256", "_mm256_or_si256"),
    ("sum", "difference"),
    ("scaled", "divided"),
];

/// The function that may be called in place of another.
fn sibling(path: &syn::Path) -> Option<syn::Path> {
    let last = path.segments.last()?;
    let name = last.ident.to_string();
    let of = |&(a, b): &(&'static str, &'static str)| match () {
        () if name == a => Some(b),
        () if name == b => Some(a),
        () => None,
    };
    let ident = syn::Ident::new(PAIRS.iter().find_map(of)?, last.ident.span());
    let intrinsic = name.starts_with('_');
    Some(match intrinsic {
        true => syn::parse_quote!(std::arch::x86_64::#ident),
        false => syn::parse_quote!(crate::simd::lanes::#ident),
    })
}

/// `if let` conditions cannot be moved.
fn has_let(expr: &Expr) -> bool {
    match expr {
        Expr::Let(_) => true,
        Expr::Binary(ExprBinary {
            op: BinOp::And(_),
            left,
            right,
            ..
        }) => has_let(left) || has_let(right),
        _ => false,
    }
}

fn literal(index: &Expr) -> Option<usize> {
    match index {
        Expr::Lit(syn::ExprLit {
            lit: syn::Lit::Int(int),
            ..
        }) => int.base10_parse().ok(),
        _ => None,
    }
}

fn is_test(attributes: &[syn::Attribute]) -> bool {
    let text = |attribute: &syn::Attribute| quote!(#attribute).to_string();
    attributes
        .iter()
        .map(text)
        .any(|text| text.contains("test"))
}

impl VisitMut for Writer<'_> {
    fn visit_item_const_mut(&mut self, _: &mut syn::ItemConst) {}
    fn visit_item_static_mut(&mut self, _: &mut syn::ItemStatic) {}
    fn visit_impl_item_const_mut(&mut self, _: &mut syn::ImplItemConst) {}
    fn visit_type_mut(&mut self, _: &mut syn::Type) {}
    fn visit_expr_const_mut(&mut self, _: &mut syn::ExprConst) {}
    fn visit_pat_mut(&mut self, _: &mut syn::Pat) {}
    fn visit_attribute_mut(&mut self, _: &mut syn::Attribute) {}

    fn visit_item_mod_mut(&mut self, module: &mut syn::ItemMod) {
        if !is_test(&module.attrs) {
            visit_mut::visit_item_mod_mut(self, module);
        }
    }

    fn visit_item_fn_mut(&mut self, function: &mut syn::ItemFn) {
        if function.sig.constness.is_none() && !is_test(&function.attrs) {
            visit_mut::visit_item_fn_mut(self, function);
        }
    }

    fn visit_impl_item_fn_mut(&mut self, function: &mut syn::ImplItemFn) {
        if function.sig.constness.is_none() {
            visit_mut::visit_impl_item_fn_mut(self, function);
        }
    }

    /// Lengths are constants.
    fn visit_expr_repeat_mut(&mut self, repeat: &mut syn::ExprRepeat) {
        self.visit_expr_mut(&mut repeat.expr);
    }

    /// A store that does not happen.
    fn visit_stmt_mut(&mut self, statement: &mut Stmt) {
        if let Stmt::Expr(Expr::MethodCall(call), Some(_)) = statement {
            let name = call.method.to_string();
            if matches!(
                name.as_str(),
                "set" | "update" | "store" | "add" | "max" | "min"
            ) {
                let what = format!("no `{name}`");
                if let Some(n) = self.next(what, line(call.method.span())) {
                    // Candidates within are counted all the same, so that numbers do not depend on what is chosen.
                    let outside = std::mem::replace(&mut self.within, true);
                    visit_mut::visit_stmt_mut(self, statement);
                    self.within = outside;
                    let old = statement.clone();
                    *statement = syn::parse_quote!(if !crate::mutant(#n) { #old });
                    return;
                }
            }
        }
        visit_mut::visit_stmt_mut(self, statement);
    }

    fn visit_expr_mut(&mut self, expr: &mut Expr) {
        let new: Option<(u32, Expr)> = match expr {
            Expr::Binary(ExprBinary {
                left, op, right, ..
            }) if !has_let(left) && !has_let(right) => other(op).and_then(|new| {
                let what = format!("`{}` to `{}`", quote!(#op), quote!(#new));
                let at = line(syn::spanned::Spanned::span(op));
                let n = self.next(what, at)?;
                Some((n, syn::parse_quote!(#left #new #right)))
            }),
            Expr::Unary(ExprUnary {
                op: UnOp::Neg(minus),
                expr: inner,
                ..
            }) => {
                let n = self.next("no sign".into(), line(minus.spans[0]));
                n.map(|n| (n, syn::parse_quote!((#inner))))
            }
            Expr::MethodCall(ExprMethodCall {
                receiver,
                method,
                args,
                ..
            }) if args.len() == 1 && (method == "min" || method == "max") => {
                let new = if method == "min" { "max" } else { "min" };
                let what = format!("`{method}` to `{new}`");
                let new = syn::Ident::new(new, method.span());
                let n = self.next(what, line(method.span()));
                n.map(|n| (n, syn::parse_quote!(#receiver.#new(#args))))
            }
            Expr::Call(ExprCall { func, args, .. }) => match func.as_ref() {
                Expr::Path(path) => sibling(&path.path).and_then(|new| {
                    let what = format!("`{}` to `{}`", quote!(#path), quote!(#new));
                    let n = self.next(what, line(syn::spanned::Spanned::span(path)))?;
                    Some((n, syn::parse_quote!(#new(#args))))
                }),
                _ => None,
            },
            Expr::Index(ExprIndex {
                expr: array, index, ..
            }) => match literal(index) {
                Some(at) => {
                    let beside = if at == 0 { 1_usize } else { at - 1 };
                    let n = self.next(
                        format!("index {at} to {beside}"),
                        line(syn::spanned::Spanned::span(index)),
                    );
                    n.map(|n| (n, syn::parse_quote!(#array[#beside])))
                }
                None => None,
            },
            _ => None,
        };
        match new {
            None => visit_mut::visit_expr_mut(self, expr),
            Some((n, new)) => {
                // Candidates within are counted all the same, so that numbers do not depend on what is chosen.
                let outside = std::mem::replace(&mut self.within, true);
                visit_mut::visit_expr_mut(self, expr);
                self.within = outside;
                let old = expr.clone();
                *expr = syn::parse_quote!((if crate::mutant(#n) { #new } else { #old }));
            }
        }
    }
}
