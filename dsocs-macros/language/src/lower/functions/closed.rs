//! Expressions of the parameters alone, which are copied into the code with `self.` before the fields.

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{ToTokens, quote_spanned};
use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::visit_mut::{self, VisitMut};
use syn::{Expr, ExprCall, ExprIndex, ExprPath, FieldValue, Member, PatIdent, Token};

use crate::check::names::RESERVED;
use crate::lower::lowering::Lowering;
use crate::lower::names::Binding;
use crate::mistakes::errors::Reported;
use crate::syntax::input::field_of_self;
use crate::syntax::{bare, plain_name};

/// A search for names of the motion or of the language.
struct OpenNameSearch<'s, 'l> {
    lowering: &'s Lowering<'l>,
    found: bool,
}

impl<'ast> Visit<'ast> for OpenNameSearch<'_, '_> {
    fn visit_expr_index(&mut self, index: &'ast ExprIndex) {
        self.visit_expr(&index.expr);
        if self.lowering.integer(&index.index).is_none() {
            self.visit_expr(&index.index);
        }
    }

    fn visit_expr_path(&mut self, path: &'ast ExprPath) {
        if let Some(name) = path.path.get_ident() {
            let open = match self.lowering.scope.get(name) {
                Some(binding) => !matches!(binding, Binding::Field(_) | Binding::Index(_)),
                None => RESERVED.iter().any(|(word, _)| name == word),
            };
            self.found |= open;
        }
        visit::visit_expr_path(self, path);
    }
}

impl Lowering<'_> {
    /// Whether an expression contains no coordinate, no `let`, no node and no word of the language.
    pub(crate) fn is_closed(&self, expr: &Expr) -> bool {
        let mut search = OpenNameSearch {
            lowering: self,
            found: false,
        };
        search.visit_expr(expr);
        !search.found
    }

    /// Whether an expression is an element of a parameter's array or matrix.
    pub(crate) fn is_element(&self, expr: &Expr) -> bool {
        let (mut base, mut places) = (bare(expr), Vec::new());
        while let Expr::Index(index) = base {
            let Some(place) = self
                .integer(&index.index)
                .and_then(|place| usize::try_from(place).ok())
            else {
                return false;
            };
            places.insert(0, place);
            base = bare(&index.expr);
        }
        let Some(Binding::Field(field)) = plain_name(base).and_then(|name| self.scope.get(name)) else {
            return false;
        };
        let shape = self.fields.get(*field).map_or(&[][..], |field| field.shape());
        !places.is_empty()
            && places.len() == shape.len()
            && places.iter().zip(shape).all(|(place, length)| place < length)
    }

    /// The tokens of a closed expression, with `self.` before the fields.
    pub(crate) fn closed(&self, expr: &Expr) -> Result<TokenStream, Reported> {
        let mut bound = BoundNames::default();
        bound.visit_expr(expr);
        let mut rewrite = Rewrite {
            lowering: self,
            bound: bound.0,
            wrong: None,
        };
        let mut rewritten = expr.clone();
        rewrite.visit_expr_mut(&mut rewritten);
        if let Some(reported) = rewrite.wrong {
            return Err(reported);
        }
        if !self.fields.have_compiler() && !self.is_element(expr) {
            return Err(self.needs_compiler(expr));
        }
        Ok(rewritten.into_token_stream())
    }
}

/// The names that patterns inside an expression bind, such as parameters of closures.
#[derive(Default)]
struct BoundNames(Vec<String>);

impl<'ast> Visit<'ast> for BoundNames {
    fn visit_pat_ident(&mut self, pattern: &'ast PatIdent) {
        self.0.push(pattern.ident.to_string());
    }
}

struct Rewrite<'r, 'l> {
    lowering: &'r Lowering<'l>,
    bound: Vec<String>,
    wrong: Option<Reported>,
}

impl Rewrite<'_, '_> {
    fn path(&mut self, path: &ExprPath) -> Option<TokenStream> {
        let name = path.path.get_ident()?;
        if self.bound.iter().any(|bound| name == bound) {
            return None;
        }
        match self.lowering.scope.get(name) {
            Some(Binding::Field(_)) => return Some(field_of_self(name)),
            Some(&Binding::Index(value)) => return Some(literal(value, name.span())),
            _ => {}
        }
        if is_circle_constant(name) {
            return Some(free(name, self.lowering.fields.have_compiler()));
        }
        if let Err(reported) = self.lowering.check_free_name(name) {
            self.wrong = Some(reported);
        }
        None
    }
}

/// A name that the declaration does not define: a constant of the user's module, or `PI` or `TAU`, which need
/// no import.
pub(crate) fn free(name: &Ident, have_compiler: bool) -> TokenStream {
    if !have_compiler || !is_circle_constant(name) {
        return name.to_token_stream();
    }
    // a constant of this name in the user's module takes precedence
    let span = Span::call_site().located_at(name.span());
    quote_spanned! {span=> {
        #[allow(unused_imports)]
        use ::dsocs_core::__private::__circle::*;
        {
            #[allow(unused_imports)]
            use self::*;
            #name
        }
    }}
}

/// Whether a name is `PI` or `TAU`, or their lower case.
pub(crate) fn is_circle_constant(name: &Ident) -> bool {
    circle_constant(&name.to_string()).is_some()
}

/// The value of `PI` or `TAU`.
pub(crate) fn circle_constant(name: &str) -> Option<f64> {
    match name {
        "PI" | "pi" => Some(core::f64::consts::PI),
        "TAU" | "tau" => Some(core::f64::consts::TAU),
        _ => None,
    }
}

impl Rewrite<'_, '_> {
    /// The value of an index in which no name is bound by the expression itself.
    fn index(&self, index: &Expr) -> Option<i64> {
        let mut names = Names::default();
        names.visit_expr(index);
        let free = names.0.iter().all(|name| !self.bound.contains(name));
        self.lowering.integer(index).filter(|_| free)
    }
}

/// The plain names in an expression.
#[derive(Default)]
struct Names(Vec<String>);

impl<'ast> Visit<'ast> for Names {
    fn visit_expr_path(&mut self, path: &'ast ExprPath) {
        self.0.extend(path.path.get_ident().map(ToString::to_string));
    }
}

/// An integer literal of the type that its context expects.
fn literal(value: i64, span: Span) -> TokenStream {
    let mut digits = Literal::u64_unsuffixed(value.unsigned_abs());
    digits.set_span(span);
    if value < 0 {
        quote_spanned!(span=> -#digits)
    } else {
        digits.into_token_stream()
    }
}

impl VisitMut for Rewrite<'_, '_> {
    fn visit_expr_mut(&mut self, expr: &mut Expr) {
        match expr {
            Expr::Path(path) => {
                if let Some(place) = self.path(path) {
                    *expr = Expr::Verbatim(place);
                }
            }
            Expr::Index(index) => {
                self.visit_expr_mut(&mut index.expr);
                match self.index(&index.index) {
                    // written as a literal, so that equal elements are one parameter
                    Some(value) => *index.index = Expr::Verbatim(literal(value, index.index.span())),
                    None => self.visit_expr_mut(&mut index.index),
                }
            }
            Expr::Macro(invocation) => {
                let message = "a macro cannot be seen into: expected the expression itself, or a function";
                self.wrong = Some(self.lowering.errors.at(invocation, message));
            }
            _ => visit_mut::visit_expr_mut(self, expr),
        }
    }

    fn visit_expr_call_mut(&mut self, call: &mut ExprCall) {
        match plain_name(&call.func).map(|name| (name, self.lowering.scope.get(name))) {
            Some((name, Some(Binding::Field(_)))) => {
                let place = field_of_self(name);
                *call.func = Expr::Verbatim(quote_spanned!(name.span()=> (#place)));
            }
            // a user's function: its name stays
            Some(_) => {}
            None => self.visit_expr_mut(&mut call.func),
        }
        for argument in &mut call.args {
            self.visit_expr_mut(argument);
        }
    }

    fn visit_field_value_mut(&mut self, field: &mut FieldValue) {
        // `Point { x }` with `x` rewritten has to be `Point { x: self.x }`
        if let Member::Named(name) = &field.member
            && field.colon_token.is_none()
        {
            field.colon_token = Some(Token![:](name.span()));
        }
        self.visit_expr_mut(&mut field.expr);
    }
}
