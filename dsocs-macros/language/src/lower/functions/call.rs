//! Calls: the words of the language, the functions of `f64`, and the user's functions.

use proc_macro2::{Ident, TokenStream};
use quote::{ToTokens, quote, quote_spanned};
use syn::{Expr, ExprCall, ExprMethodCall};

use crate::graph::{Callee, NodeId};
use crate::lower::functions::builtin::{Builtin, is_not_supported};
use crate::lower::lowering::{DerivativeTokens, Lowered, Lowering};
use crate::lower::names::Binding;
use crate::lower::names::foreign_names::is_module;
use crate::lower::values::{Value, Valued};
use crate::mistakes::errors::Reported;
use crate::mistakes::nearest::{did_you_mean, nearest};
use crate::syntax::input::{Field, Kind, field_of_self};
use crate::syntax::{bare, plain_name};

/// `name` in `f64::name`.
fn function_of_f64(function: &Expr) -> Option<&Ident> {
    match function {
        Expr::Path(path) if path.qself.is_none() && path.path.segments.len() == 2 => {
            let of_f64 = path.path.segments[0].ident == "f64";
            of_f64.then(|| &path.path.segments[1].ident)
        }
        _ => None,
    }
}

impl Lowering<'_> {
    /// `function(…)`
    pub(crate) fn call(&mut self, call: &ExprCall, whole: &Expr) -> Valued {
        let arguments: Vec<_> = call.args.iter().collect();
        if let Some(name) = plain_name(&call.func) {
            let text = name.to_string();
            match self.scope.get(name) {
                // checked first, also where a `let` has taken one of these names, which is reported elsewhere
                _ if matches!(text.as_str(), "dot" | "ddot" | "dddot") => return self.dot(name, call),
                _ if text == "sum" || text == "product" => return self.over_range(name, call),
                _ if text == "each" => {
                    return Err(self.errors.at(
                        name,
                        "`each(…)` stands for entries of a list, such as `holonomic = each(0..8, |i| …);`; expected a number, such as \
                         `sum(0..8, |i| …)`",
                    ));
                }
                None if self.discrete.is_some() && (text == "leg" || text == "node") => {
                    return self.leg_or_node(name, call);
                }
                Some(Binding::Function(function)) => {
                    let function = function.clone();
                    return self.apply(name, &function, call);
                }
                Some(Binding::Field(index))
                    if self
                        .fields
                        .get(*index)
                        .is_some_and(|field| field.kind == Kind::Number) =>
                {
                    return Err(self.called_number(name));
                }
                Some(Binding::Field(index)) if self.is_table_at(*index) => {
                    return Err(self.whole_table(name));
                }
                Some(Binding::Field(_)) if !self.fields.have_compiler() => {
                    return Err(self.called_array(name));
                }
                Some(Binding::Field(_)) if !self.is_closed(whole) => {
                    let place = field_of_self(name);
                    let callee = Callee::Function(quote_spanned!(name.span()=> (#place)));
                    return self.user_call(callee, None, &arguments).map(Value::Number);
                }
                Some(Binding::Field(_)) => {}
                Some(Binding::Let(Err(reported)) | Binding::OfMap(Err(reported))) => return Err(*reported),
                Some(binding) => {
                    let kind = binding.kind();
                    let message =
                        format!("expected a function, but `{name}` is {kind}; a product is written with `*`");
                    return Err(self.errors.at(name, message));
                }
                None if text == "t" => {
                    let message = "`t` is time, and no function; a product is written with `*`";
                    return Err(self.errors.at(name, message));
                }
                None if is_higher_derivative(&text) => return Err(self.derivative_too_high(name)),
                None if self.functions.contains(&text) => {
                    return Err(self.errors.at(
                        name,
                        format!(
                            "`{text}` is defined further down, or here; expected its `let` before this use"
                        ),
                    ));
                }
                None => {
                    if let Some(reported) = self.foreign_function(name, call.args.first()) {
                        return Err(reported);
                    }
                }
            }
        } else if let Expr::Lit(number) = bare(&call.func) {
            return Err(self
                .errors
                .at(number, "a number is no function; a product is written with `*`"));
        } else if let Some(name) = function_of_f64(&call.func) {
            let builtin = Builtin::find(&name.to_string());
            if let (Some(builtin), Some((receiver, rest))) = (builtin, arguments.split_first()) {
                return self.builtin(builtin, name, receiver, rest).map(Value::Number);
            }
            if !self.is_closed(whole) {
                let hint = did_you_mean(&name.to_string(), Builtin::names());
                return Err(self.errors.at(
                    name,
                    format!("`f64::{name}` has no derivative that is known here{hint}"),
                ));
            }
        }
        if !self.fields.have_compiler() {
            return Err(match plain_name(&call.func) {
                Some(name) => self.unknown_function(name),
                None => self.needs_compiler(&call.func),
            });
        }
        if self.is_closed(whole) {
            return self.param(whole).map(Value::Number);
        }
        let callee = match &*call.func {
            Expr::Path(path) => path.to_token_stream(),
            other if self.is_closed(other) => self.closed(other)?,
            other => return Err(self.errors.at(other, "expected the name of a function")),
        };
        self.user_call(Callee::Function(callee), None, &arguments)
            .map(Value::Number)
    }

    /// The error for the call of a number.
    fn called_number(&self, name: &Ident) -> Reported {
        let message = format!(
            "expected a function, but `{name}` is a number; a product is written with `*`, and what depends on time or position is {}",
            self.errors.words(
                "a function of yours, such as `table.at(t)`",
                "a function, `let f = |x| …;`, or a table of samples, `table.at(t)`",
            )
        );
        self.errors.at(name, message)
    }

    /// The error for the call of an array, in a text.
    fn called_array(&self, name: &Ident) -> Reported {
        let message = format!(
            "expected a function, but `{name}` is an array of numbers; its first is `{name}[0]`, and a product is written with `*`"
        );
        self.errors.at(name, message)
    }

    /// The error for a derivative beyond the third.
    fn derivative_too_high(&self, name: &Ident) -> Reported {
        let message = "expected at most a third derivative, `dddot(…)`: constraints bind up to four nodes";
        self.errors.at(name, message)
    }

    /// `receiver.method(…)`
    pub(crate) fn method_call(&mut self, call: &ExprMethodCall, whole: &Expr) -> Valued {
        let name = call.method.to_string();
        let arguments: Vec<_> = call.args.iter().collect();
        if let Some(module) = self.module(&call.receiver) {
            return Err(self.function_of_module(module, &call.method, call.args.first()));
        }
        if let Some(builtin) = Builtin::find(&name)
            && !self.is_no_number(&call.receiver)
        {
            return self
                .builtin(builtin, &call.method, &call.receiver, &arguments)
                .map(Value::Number);
        }
        if let Some(table) = self.table(&call.receiver) {
            if call.method != "at" || arguments.len() != 1 {
                let message = format!("expected the value of the samples at one place, `{table}.at(t)`");
                return Err(self.errors.at(&call.method, message));
            }
            let (place, dot, method) = (field_of_self(table), &call.dot_token, &call.method);
            let callee = Callee::Function(quote!(#place #dot #method));
            return self.user_call(callee, None, &arguments).map(Value::Number);
        }
        if let Some(value) = self.method_of_vectors(call) {
            return value;
        }
        if self.fields.have_compiler() && self.is_closed(whole) {
            return self.param(whole).map(Value::Number);
        }
        if self.fields.have_compiler() && self.is_closed(&call.receiver) {
            let receiver = self.closed(&call.receiver)?;
            let (dot, method, turbofish) = (&call.dot_token, &call.method, &call.turbofish);
            let callee: TokenStream = quote!(#receiver #dot #method #turbofish);
            return self
                .user_call(Callee::Function(callee), None, &arguments)
                .map(Value::Number);
        }
        if let Some(turbofish) = &call.turbofish {
            let message = self.errors.words(
                "expected no type arguments: the type of the number varies",
                "this has no meaning here",
            );
            return Err(self.errors.at(turbofish, message));
        }
        if matches!(name.as_str(), "dot" | "ddot" | "dddot") && arguments.is_empty() {
            let receiver = call.receiver.to_token_stream().to_string().replace(' ', "");
            return Err(self
                .errors
                .at(&call.method, format!("expected `{name}({receiver})`")));
        }
        if name == "dot" && arguments.len() == 1 {
            let message =
                "`dot` is the time derivative; expected `a.inner(b)` for the inner product of two vectors";
            return Err(self.errors.at(&call.method, message));
        }
        let receiver = match self.value(&call.receiver)? {
            Value::Number(receiver) => receiver,
            other => return Err(self.no_method_of_vectors(&call.method, &other)),
        };
        if let Some(reported) = self.foreign_method(&call.method) {
            return Err(reported);
        }
        if is_not_supported(&name) && self.graph.leaves(receiver).next().is_some() {
            return Err(self.errors.at(
                &call.method,
                format!(
                    "`{name}` has no derivative along the motion; \
                     expected a smooth function, `if … {{ … }} else {{ … }}`, `min` or `max`"
                ),
            ));
        }
        if !self.fields.have_compiler() {
            let hint = did_you_mean(&name, Builtin::names());
            return Err(self
                .errors
                .at(&call.method, format!("no function is called `{name}`{hint}")));
        }
        self.user_call(Callee::Method(call.method.clone()), Some(receiver), &arguments)
            .map(Value::Number)
    }

    /// Whether a field is a table of samples, in a declaration that no compiler reads.
    pub(crate) fn is_table_at(&self, index: usize) -> bool {
        !self.fields.have_compiler() && self.fields.get(index).is_some_and(Field::is_table)
    }

    /// The error for a table of samples in place of a number.
    pub(crate) fn whole_table(&self, name: &Ident) -> Reported {
        let message =
            format!("`{name}` is a table of samples; expected its value at a place, `{name}.at(t)`");
        self.errors.at(name, message)
    }

    /// The table of samples that an expression names, in a declaration that no compiler reads.
    fn table<'e>(&self, expr: &'e Expr) -> Option<&'e Ident> {
        let name = plain_name(bare(expr))?;
        match self.scope.get(name) {
            Some(Binding::Field(index)) => self.is_table_at(*index).then_some(name),
            _ => None,
        }
    }

    /// The error for a function that is neither of the language nor of the declaration.
    fn unknown_function(&self, name: &Ident) -> Reported {
        let text = name.to_string();
        let own = nearest(&text, self.functions.iter().map(String::as_str));
        let message = match (own, nearest(&text, Builtin::names())) {
            (Some(near), _) => format!("no function `{text}` is known here; did you mean `{near}`?"),
            (None, Some(near)) => {
                format!(
                    "no function `{text}` is known here; did you mean `.{near}()`, which stands behind what it is of?"
                )
            }
            (None, None) => format!(
                "no function `{text}` is known here; a function of your own is written `let {text} = |x| …;`"
            ),
        };
        self.errors.at(name, message)
    }

    /// The module that an expression names in other languages: `np` in `np.sin(x)`.
    pub(crate) fn module<'e>(&self, expr: &'e Expr) -> Option<&'e Ident> {
        plain_name(expr).filter(|name| is_module(name) && self.scope.get(name).is_none())
    }

    fn user_call(&mut self, callee: Callee, receiver: Option<NodeId>, arguments: &[&Expr]) -> Lowered {
        let arguments: Vec<_> = arguments.iter().map(|argument| self.argument(argument)).collect();
        let arguments: Vec<_> = receiver
            .into_iter()
            .map(Ok)
            .chain(arguments)
            .collect::<Result<_, _>>()?;
        Ok(self.graph.call(callee, &arguments))
    }

    /// An argument of a user's function.
    fn argument(&mut self, argument: &Expr) -> Lowered {
        if let Expr::Reference(reference) = argument {
            return Err(self.errors.at(
                reference,
                "expected a number: the arguments of a function are numbers; \
                 a function that needs other data is a method of them, `data.function(x)`",
            ));
        }
        self.expr(argument)
    }

    /// Whether an expression is a field whose type is not known to be a number.
    fn is_no_number(&self, expr: &Expr) -> bool {
        let field = plain_name(bare(expr)).and_then(|name| match self.scope.get(name) {
            Some(Binding::Field(index)) => self.fields.get(*index),
            _ => None,
        });
        field.is_some_and(|field| !matches!(field.kind, Kind::Number | Kind::Exact))
    }

    /// `dot(e)`, `ddot(e)` or `dddot(e)`.
    fn dot(&mut self, name: &Ident, call: &ExprCall) -> Valued {
        let Some(argument) = call.args.first().filter(|_| call.args.len() == 1) else {
            let inner = match (call.args.len(), name == "dot") {
                (2, true) => "; the inner product of two vectors is written `a.inner(b)`",
                _ => "",
            };
            return Err(self.errors.at(
                call,
                format!(
                    "expected one argument, `{name}(…)`, found {}{inner}",
                    call.args.len()
                ),
            ));
        };
        if self.component.is_some() {
            return Err(self.errors.at(
                name,
                "a map knows the nodes, not the motion; expected a difference quotient, such as `(q1 - q0) / h`",
            ));
        }
        if self.discrete.is_some() {
            return Err(self.motion_among_nodes(call, false));
        }
        if plain_name(argument).is_some_and(|name| name == "t") {
            return Err(self.errors.at(
                call,
                "`t` is time itself, which goes on at the rate 1: leave this out; expected the derivative of something that moves, `dot(x)`",
            ));
        }
        let value = self.value(argument)?;
        if let Value::Rotation(_) = value {
            let message = "the rate of a rotation is its angular velocity, in the frame of its body: expected `r.angular_velocity()`";
            return Err(self.errors.at(call, message));
        }
        let times = match name.to_string().as_str() {
            "dddot" => 3,
            "ddot" => 2,
            _ => 1,
        };
        value.map(|value| self.derivative(value, times, call))
    }

    /// The `times`-th time derivative of a number.
    fn derivative(&mut self, mut value: NodeId, times: usize, call: &ExprCall) -> Lowered {
        let order = self.graph.order(value).map_or(0, |order| order + times);
        if order > 3 {
            return Err(self.errors.at(
                call,
                format!(
                    "this derivative is of order {order}; expected at most order 3, a jerk, in a kinematic constraint, and order 2, an \
                     acceleration, elsewhere"
                ),
            ));
        }
        self.differentiated.push(value);
        for _ in 0..times {
            value = self.graph.total_derivative(value);
        }
        self.record_derivative(call, value);
        Ok(value)
    }

    /// Records where a derivative enters the expression, for messages.
    pub(crate) fn record_derivative(&mut self, tokens: impl ToTokens, node: NodeId) {
        if let Some(order) = self.graph.order(node) {
            self.derivatives.push(DerivativeTokens {
                tokens: tokens.into_token_stream(),
                order,
            });
        }
    }
}

/// Whether a name is that of a derivative beyond the third, such as `ddddot`.
fn is_higher_derivative(text: &str) -> bool {
    let rest = text.strip_suffix("ddddot");
    rest.is_some_and(|rest| rest.chars().all(|c| c == 'd'))
}
