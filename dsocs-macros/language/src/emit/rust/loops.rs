//! Similar operations as loops.
//!
//! Where a method has thousands of operations, similar ones ([`crate::program::cells`]) become loops over arrays.
//! Every operation, and so every bit, is the same as in straight-line code, but the code is that of one link.
//!
//! Operations of one kind are in one array, in the order of their operands, so that most operands are read one
//! after the other, or are the same many times in a row: a *run*. Kinds with equally many members, whose
//! operands belong together one by one, are computed in one loop ([`Group`]).

use std::cmp::Ordering;
use std::collections::BTreeSet;

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::quote;

use super::place::{Place, number};
use crate::graph::Comparison;
use crate::hash::HashMap;
use crate::program::cells::{Kind, Kinds, Operation};
use crate::program::schedule::Schedule;
use crate::program::{Op, Program, Value};

/// The fewest operations of one kind that make a loop.
const FEWEST: usize = 6;

/// The most arrays that a loop reads, where one that is read twice counts twice.
const MOST_INPUTS: usize = 24;

/// The expression of an operation.
fn written(operation: Operation, parts: &[TokenStream]) -> TokenStream {
    let function = |name: &str| {
        let name = Ident::new(name, Span::call_site());
        quote!(__T::#name(#(#parts),*))
    };
    match (operation, parts) {
        (Operation::Neg, [a]) => quote!(-#a),
        (Operation::Add, [a, b]) => quote!(#a + #b),
        (Operation::Sub, [a, b]) => quote!(#a - #b),
        (Operation::Mul, [a, b]) => quote!(#a * #b),
        (Operation::Div, [a, b]) => quote!(#a / #b),
        (Operation::Recip, _) => function("recip"),
        (Operation::Powi(n), [a]) => {
            let n = Literal::i32_unsuffixed(n);
            quote!(__T::powi(#a, #n))
        }
        (Operation::Unary(op), _) => function(op.name()),
        (Operation::Powf, _) => function("powf"),
        (Operation::Atan2, _) => function("atan2"),
        (Operation::Select(Comparison::Lt), _) => function("select_lt"),
        (Operation::Select(Comparison::Le), _) => function("select_le"),
        _ => quote!(::core::unreachable!()), // every operation has its number of operands
    }
}

/// The place of an operand.
#[derive(Clone, PartialEq, Eq, Debug)]
enum OperandPlace {
    /// A number, or a value with a name of its own.
    One(Value),
    /// An element of an argument: its text, and the index.
    Argument(String, usize),
    /// A member of a kind: the kind, and the index.
    Member(usize, usize),
}

/// The operands of some operations in the same position.
struct Slot {
    /// The array, or the single value.
    array: Array,
    /// The index for every member; empty for a single value.
    elements: Vec<usize>,
}

#[derive(Clone, PartialEq, Eq, Debug)]
enum Array {
    One(Value),
    Argument(String),
    Kind(usize),
}

/// The order of the indices of a slot.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum IndexOrder {
    /// Increasing by one.
    Consecutive,
    /// Constant.
    Constant,
    /// Any order, given by a list.
    Listed,
}

/// One operation for every cell of a group.
struct LoopStatement {
    /// The number of the kind.
    kind: usize,
    operation: Operation,
    slots: Vec<Slot>,
}

/// Kinds with equally many members, computed in one loop.
struct Group {
    count: usize,
    statements: Vec<LoopStatement>,
    is_call: bool,
}

impl Group {
    /// The operands that the loop reads from arrays of other groups or arguments.
    fn external_operands(&self) -> impl Iterator<Item = &Slot> {
        let own = |slot: &&Slot| match slot.array {
            Array::One(_) => true,
            Array::Argument(_) => false,
            Array::Kind(kind) => self.statements.iter().any(|statement| statement.kind == kind),
        };
        let slots = self.statements.iter().flat_map(|statement| &statement.slots);
        slots.filter(move |slot| !own(slot))
    }
}

/// The arrays that a group reads, with the order of their indices.
struct Inputs<'a> {
    slots: Vec<&'a Slot>,
    orders: Vec<IndexOrder>,
}

impl<'a> Inputs<'a> {
    fn new(group: &'a Group) -> Self {
        let mut inputs = Self {
            slots: Vec::new(),
            orders: Vec::new(),
        };
        for slot in group.external_operands() {
            if inputs.position(slot).is_none() {
                inputs.slots.push(slot);
                inputs.orders.push(index_order(&slot.elements));
            }
        }
        inputs
    }

    /// The index of the input that is read in a slot.
    fn position(&self, slot: &Slot) -> Option<usize> {
        let same = |known: &&Slot| known.array == slot.array && known.elements == slot.elements;
        self.slots.iter().position(same)
    }

    /// The lists of indices of inputs that are read in any order.
    fn lists(&self) -> TokenStream {
        let lists = self.slots.iter().zip(&self.orders).enumerate();
        let lists = lists.filter(|(_, (_, order))| **order == IndexOrder::Listed);
        let lists = lists.map(|(input, (slot, _))| {
            let (name, count) = (list_name(input), Literal::usize_unsuffixed(slot.elements.len()));
            let elements = slot.elements.iter().copied().map(Literal::usize_unsuffixed);
            quote!(static #name: [u32; #count] = [#(#elements),*];)
        });
        lists.collect()
    }
}

/// A function that writes one operation, given a function that writes an operand.
type Write<'a> = dyn Fn(Value, &dyn Fn(Value) -> TokenStream) -> TokenStream + 'a;

/// An item of the code, in order.
enum Item {
    One(Value),
    Group(Group),
    /// Moved to a later position.
    Moved,
}

/// The code of a method, with loops.
pub(super) struct Loops<'a, 'g> {
    program: &'a Program<'g>,
    schedule: &'a Schedule,
    names: &'a HashMap<Value, Ident>,
    /// The prefix of names.
    prefix: &'a str,
    places: HashMap<Value, Place>,
    items: Vec<Item>,
    /// The item that computes a kind; none for kinds that are computed one by one.
    item_of_kind: HashMap<usize, usize>,
    item_of_one: HashMap<Value, usize>,
    at: HashMap<Value, OperandPlace>,
    /// Arguments by their text.
    arguments: HashMap<String, TokenStream>,
    /// The number of members of each kind.
    counts: HashMap<usize, usize>,
}

impl<'a, 'g> Loops<'a, 'g> {
    /// Sorts the operations of a method into items; `given` is the kind of a value that another method has
    /// computed.
    pub(super) fn new(
        program: &'a Program<'g>,
        schedule: &'a Schedule,
        (prefix, names): (&'a str, &'a HashMap<Value, Ident>),
        places: HashMap<Value, Place>,
        given: &dyn Fn(Value) -> usize,
    ) -> Self {
        let mut cells = Self {
            program,
            schedule,
            names,
            prefix,
            places,
            items: Vec::new(),
            item_of_kind: HashMap::default(),
            item_of_one: HashMap::default(),
            at: HashMap::default(),
            arguments: HashMap::default(),
            counts: HashMap::default(),
        };
        let mut kinds = Kinds::new();
        let mut members: Vec<Vec<Value>> = Vec::new();
        for &value in &schedule.values {
            let kind = cells.kind(&mut kinds, value, given);
            let number = kinds.add(value, kind);
            if members.len() <= number {
                members.resize_with(number + 1, Vec::new);
            }
            members[number].push(value);
        }
        for (kind, members) in members.into_iter().enumerate() {
            cells.place(&kinds, kind, members);
        }
        cells
    }

    /// The kind of a value; its place is recorded, too.
    fn kind(&mut self, kinds: &mut Kinds, value: Value, given: &dyn Fn(Value) -> usize) -> Kind {
        if let Some(place) = self.places.get(&value) {
            let at = match place.argument() {
                Some((array, element)) => {
                    let text = array.to_string();
                    let at = OperandPlace::Argument(text.clone(), element);
                    self.arguments.entry(text).or_insert_with(|| array.clone());
                    at
                }
                None => OperandPlace::One(value),
            };
            self.at.insert(value, at);
            return match self.program.op(value) {
                Op::Leaf(leaf) => Kind::Leaf(std::mem::discriminant(leaf)),
                Op::Param(_) => Kind::Parameter,
                _ => Kind::Given(given(value)),
            };
        }
        let Some((operation, parts)) = self.program.operation_of(value, Some(self.schedule)) else {
            return Kind::Alone(value);
        };
        for &part in &parts {
            if let Op::Constant(bits) = self.program.op(part) {
                kinds.add(part, Kind::Constant(*bits));
                self.at.insert(part, OperandPlace::One(part));
            }
        }
        let parts = kinds.ordered(operation, parts);
        let orders = parts.windows(2).map(|pair| {
            let [a, b] = [pair[0], pair[1]].map(|part| self.program.cell(part));
            if a.varies && b.varies {
                a.key.cmp(&b.key)
            } else {
                Ordering::Equal
            }
        });
        let orders = orders.collect();
        let parts = parts.iter().map(|part| kinds.of.get(part).copied());
        match parts.collect() {
            Some(parts) => Kind::Operation(operation, parts, orders),
            None => Kind::Alone(value),
        }
    }

    /// Places the members of a kind in a loop or one by one.
    fn place(&mut self, kinds: &Kinds, kind: usize, members: Vec<Value>) {
        if members
            .first()
            .is_some_and(|value| self.places.contains_key(value))
        {
            return;
        }
        if members.len() < FEWEST || !self.place_group(kinds, kind, &members) {
            for value in members {
                self.at.insert(value, OperandPlace::One(value));
                self.item_of_one.insert(value, self.items.len());
                self.items.push(Item::One(value));
            }
        }
    }

    /// Places the members of a kind in a loop; `false` if their operands are too scattered.
    fn place_group(&mut self, kinds: &Kinds, kind: usize, members: &[Value]) -> bool {
        let Some((operation, first)) = self.program.operation_of(members[0], Some(self.schedule)) else {
            return false;
        };
        let mut rows: Vec<(Vec<OperandPlace>, Value)> = Vec::new();
        for &value in members {
            let Some((operation, parts)) = self.program.operation_of(value, Some(self.schedule)) else {
                return false;
            };
            let parts = kinds.ordered(operation, parts);
            let places: Option<Vec<OperandPlace>> =
                parts.iter().map(|part| self.at.get(part).cloned()).collect();
            let Some(places) = places else {
                return false;
            };
            rows.push((places, value));
        }
        // the last slot with each member of an earlier group once decides the order
        let leading = (0..first.len())
            .rev()
            .find(|&slot| self.counts_cells(&rows, slot));
        rows.sort_by_cached_key(|(parts, value)| {
            let element = |at: &OperandPlace| match at {
                OperandPlace::One(_) => 0,
                OperandPlace::Argument(_, element) | OperandPlace::Member(_, element) => *element,
            };
            let first = leading.map(|slot| element(&parts[slot]));
            let elements: Vec<usize> = parts.iter().map(element).collect();
            (first, &self.program.cell(*value).key, elements, *value)
        });
        let slots: Option<Vec<Slot>> = (0..first.len()).map(|slot| slot_of(&rows, slot)).collect();
        let Some(slots) = slots else {
            return false;
        };
        for (place, (_, value)) in rows.iter().enumerate() {
            self.at.insert(*value, OperandPlace::Member(kind, place));
        }
        self.counts.insert(kind, rows.len());
        let statement = LoopStatement {
            kind,
            operation,
            slots,
        };
        let item = self.item_for(&statement, rows.len());
        self.item_of_kind.insert(kind, item);
        match &mut self.items[item] {
            Item::Group(group) => group.statements.push(statement),
            Item::One(_) | Item::Moved => return false, // `item_for` returns groups only
        }
        true
    }

    /// Whether a slot has each member of another kind exactly once.
    fn counts_cells(&self, rows: &[(Vec<OperandPlace>, Value)], slot: usize) -> bool {
        let mut seen = BTreeSet::new();
        let mut kinds = BTreeSet::new();
        for (parts, _) in rows {
            let OperandPlace::Member(kind, element) = parts[slot] else {
                return false;
            };
            kinds.insert(kind);
            seen.insert(element);
        }
        kinds.len() == 1
            && seen.len() == rows.len()
            && kinds.iter().all(|kind| self.counts[kind] == rows.len())
    }

    /// The group that computes a statement: the last one of the same size into which it fits, or a new one.
    fn item_for(&mut self, statement: &LoopStatement, count: usize) -> usize {
        let is_call = statement.operation.is_call();
        let needs = |slot: &Slot| match &slot.array {
            Array::One(value) => self.item_of_one.get(value).copied(),
            Array::Argument(_) => None,
            Array::Kind(kind) => self.item_of_kind.get(kind).copied(),
        };
        // whether a slot reads, in the order of the cells, the results of the group itself
        let own = |slot: &Slot, item: usize| {
            needs(slot) == Some(item)
                && matches!(slot.array, Array::Kind(_))
                && slot
                    .elements
                    .iter()
                    .enumerate()
                    .all(|(place, &element)| place == element)
        };
        let goes_with = |item: usize| match &self.items[item] {
            Item::Group(group) if group.count == count && group.is_call == is_call => {
                let external = statement.slots.iter().filter(|slot| !own(slot, item));
                let slots: Vec<&Slot> = external.clone().chain(group.external_operands()).collect();
                let joint = runs_of(count, &slots).len();
                let [one, other] = [external.collect(), group.external_operands().collect::<Vec<_>>()]
                    .map(|slots: Vec<&Slot>| runs_of(count, &slots).len());
                slots.len() <= MOST_INPUTS && joint <= one.max(other) + 1
            }
            _ => false,
        };
        for item in (0..self.items.len()).rev().filter(|&item| goes_with(item)) {
            if statement
                .slots
                .iter()
                .all(|slot| own(slot, item) || needs(slot).is_none_or(|needed| needed < item))
            {
                return item;
            }
            // or the group is moved to the end, if nothing has read it yet
            let later = statement
                .slots
                .iter()
                .all(|slot| own(slot, item) || needs(slot) != Some(item));
            if later && !self.is_read_after(item) {
                return self.move_to_end(item);
            }
        }
        self.items.push(Item::Group(Group {
            count,
            statements: Vec::new(),
            is_call,
        }));
        self.items.len() - 1
    }

    /// Whether an item after this one reads its values.
    fn is_read_after(&self, item: usize) -> bool {
        let Item::Group(group) = &self.items[item] else {
            return true;
        };
        let kinds: BTreeSet<usize> = group.statements.iter().map(|statement| statement.kind).collect();
        self.items[item + 1..].iter().any(|later| match later {
            Item::Moved => false,
            Item::Group(later) => {
                let slots = later.statements.iter().flat_map(|statement| &statement.slots);
                slots
                    .into_iter()
                    .any(|slot| matches!(slot.array, Array::Kind(kind) if kinds.contains(&kind)))
            }
            Item::One(value) => self
                .operands_of(*value)
                .iter()
                .any(|part| matches!(self.at.get(part), Some(OperandPlace::Member(kind, _)) if kinds.contains(kind))),
        })
    }

    /// The operands of a single operation.
    fn operands_of(&self, value: Value) -> Vec<Value> {
        match self.program.operation_of(value, Some(self.schedule)) {
            Some((_, parts)) => parts,
            None => self.program.op(value).parts(),
        }
    }

    fn move_to_end(&mut self, item: usize) -> usize {
        let group = std::mem::replace(&mut self.items[item], Item::Moved);
        let end = self.items.len();
        if let Item::Group(group) = &group {
            for statement in &group.statements {
                self.item_of_kind.insert(statement.kind, end);
            }
        }
        self.items.push(group);
        end
    }

    /// The statements, then an expression for each output.
    pub(super) fn code(&self, outputs: &[Value], operation: &Write<'_>) -> (TokenStream, Vec<TokenStream>) {
        let read = self.kinds_read_outside(outputs);
        let operand = |value: Value| self.operand(value);
        let statements = self
            .in_order(outputs)
            .into_iter()
            .map(|item| match &self.items[item] {
                Item::Moved => TokenStream::new(),
                Item::One(value) => {
                    let (name, right) = (&self.names[value], operation(*value, &operand));
                    quote!(let #name = #right;)
                }
                Item::Group(group) => self.group(group, &read),
            });
        let statements = statements.collect();
        (
            statements,
            outputs.iter().map(|&output| self.operand(output)).collect(),
        )
    }

    /// The item that computes a value.
    fn item_of(&self, value: Value) -> Option<usize> {
        match self.at.get(&value)? {
            OperandPlace::Member(kind, _) => self.item_of_kind.get(kind).copied(),
            OperandPlace::One(value) => self.item_of_one.get(value).copied(),
            OperandPlace::Argument(..) => None,
        }
    }

    /// The items in the order of computation. Each sum is computed from its first term to its last, so that
    /// it stays in a register.
    fn in_order(&self, outputs: &[Value]) -> Vec<usize> {
        let (mut order, mut done, mut begun) = (Vec::new(), BTreeSet::new(), BTreeSet::new());
        for &output in outputs {
            let mut open = Vec::from_iter(self.item_of(output));
            while let Some(&item) = open.last() {
                if done.contains(&item) {
                    open.pop();
                    continue;
                }
                if begun.insert(item) {
                    open.extend(
                        self.needed_by(item)
                            .into_iter()
                            .rev()
                            .filter(|needed| !done.contains(needed)),
                    );
                    continue;
                }
                open.pop();
                done.insert(item);
                order.push(item);
            }
        }
        order
    }

    /// The items whose values an item reads.
    fn needed_by(&self, item: usize) -> Vec<usize> {
        match &self.items[item] {
            Item::Moved => Vec::new(),
            Item::One(value) => self
                .operands_of(*value)
                .iter()
                .filter_map(|&part| self.item_of(part))
                .collect(),
            Item::Group(group) => {
                let slots = group.statements.iter().flat_map(|statement| &statement.slots);
                let items = slots.filter_map(|slot| match &slot.array {
                    Array::One(value) => self.item_of_one.get(value).copied(),
                    Array::Argument(_) => None,
                    Array::Kind(kind) => self.item_of_kind.get(kind).copied(),
                });
                items.filter(|&needed| needed != item).collect()
            }
        }
    }

    /// The expression for a value.
    fn operand(&self, value: Value) -> TokenStream {
        match self.at.get(&value) {
            Some(OperandPlace::Member(kind, element)) => {
                let (array, element) = (self.array_name(*kind), Literal::usize_unsuffixed(*element));
                quote!(#array[#element])
            }
            Some(OperandPlace::Argument(text, element)) => {
                let (array, element) = (&self.arguments[text], Literal::usize_unsuffixed(*element));
                quote!(#array[#element])
            }
            Some(OperandPlace::One(_)) | None => match (self.program.op(value), self.places.get(&value)) {
                (Op::Constant(bits), _) => number(bits.get()),
                (_, Some(place)) => place.read(),
                _ => {
                    let name = &self.names[&value];
                    quote!(#name)
                }
            },
        }
    }

    /// The kinds whose members are read outside their group; these are stored in arrays.
    fn kinds_read_outside(&self, outputs: &[Value]) -> BTreeSet<usize> {
        let mut read = BTreeSet::new();
        let mut member = |value: &Value| {
            if let Some(OperandPlace::Member(kind, _)) = self.at.get(value) {
                read.insert(*kind);
            }
        };
        outputs.iter().for_each(&mut member);
        for item in &self.items {
            if let Item::One(value) = item {
                self.operands_of(*value).iter().for_each(&mut member);
            }
        }
        for item in &self.items {
            if let Item::Group(group) = item {
                for slot in group.statements.iter().flat_map(|statement| &statement.slots) {
                    if let Array::Kind(kind) = slot.array
                        && !group.statements.iter().any(|statement| statement.kind == kind)
                    {
                        read.insert(kind);
                    }
                }
            }
        }
        read
    }

    /// The loop of a group.
    fn group(&self, group: &Group, read: &BTreeSet<usize>) -> TokenStream {
        let inputs = Inputs::new(group);
        let starts = run_starts(group.count, &inputs.slots, &inputs.orders);
        let body = self.body(group, &inputs, read);
        let kinds = group.statements.iter().map(|statement| statement.kind);
        let stored: Vec<usize> = kinds.filter(|kind| read.contains(kind)).collect();
        let count = Literal::usize_unsuffixed(group.count);
        let arrays = stored.iter().map(|&kind| {
            let name = self.array_name(kind);
            quote!(let mut #name = [__T::splat(0.0); #count];)
        });
        let (arrays, lists): (TokenStream, _) = (arrays.collect(), inputs.lists());
        let [place, start, length, run, runs] =
            ["place", "start", "length", "run", "RUNS"].map(|name| Ident::new(name, Span::mixed_site()));
        let element =
            |input: usize, cell: usize| Literal::usize_unsuffixed(inputs.slots[input].elements[cell]);
        if starts.len() == 1 {
            let first = |input: usize| {
                let element = element(input, 0);
                quote!(#element)
            };
            let views = self.views(&inputs, &stored, &first, (&quote!(0), &quote!(#count)));
            return quote!(#arrays { #lists #views for #place in 0..#count { #body } });
        }
        let ends = starts[1..].iter().copied().chain([group.count]);
        let rows = starts.iter().zip(ends).map(|(&start, end)| {
            let of_inputs = (0..inputs.slots.len()).map(|input| element(input, start));
            let [start, length] = [start, end - start].map(Literal::usize_unsuffixed);
            quote!([#start, #length, #(#of_inputs),*])
        });
        let rows: Vec<TokenStream> = rows.collect();
        let [width, height] = [2 + inputs.slots.len(), rows.len()].map(Literal::usize_unsuffixed);
        let firsts: Vec<Ident> = (0..inputs.slots.len()).map(first_name).collect();
        let first = |input: usize| {
            let name = first_name(input);
            quote!(#name)
        };
        let views = self.views(&inputs, &stored, &first, (&quote!(#start), &quote!(#length)));
        quote! {
            #arrays
            {
                static #runs: [[u32; #width]; #height] = [#(#rows),*];
                #lists
                for #run in &#runs {
                    let [#start, #length, #(#firsts),*] = #run.map(|x| x as usize);
                    #views
                    for #place in 0..#length { #body }
                }
            }
        }
    }

    /// The loop's body: the operations for one cell of a group.
    fn body(&self, group: &Group, inputs: &Inputs, read: &BTreeSet<usize>) -> TokenStream {
        let place = Ident::new("place", Span::mixed_site());
        let expression = |slot: &Slot| match (&slot.array, inputs.position(slot)) {
            (Array::One(value), _) => self.operand(*value),
            (Array::Kind(kind), None) => {
                let name = value_name(*kind);
                quote!(#name)
            }
            (array, input) => {
                let input = input.unwrap_or_default();
                let name = input_name(input);
                match inputs.orders[input] {
                    IndexOrder::Constant => quote!(#name),
                    IndexOrder::Consecutive => quote!(#name[#place]),
                    IndexOrder::Listed => {
                        let array = self.array(array);
                        quote!(#array[#name[#place] as usize])
                    }
                }
            }
        };
        let statements = group.statements.iter().map(|statement| {
            let parts: Vec<TokenStream> = statement.slots.iter().map(expression).collect();
            let (name, right) = (value_name(statement.kind), written(statement.operation, &parts));
            let store = read.contains(&statement.kind).then(|| {
                let array = output_name(statement.kind);
                quote!(#array[#place] = #name;)
            });
            quote!(let #name = #right; #store)
        });
        statements.collect()
    }

    /// The slices that a run reads and writes, each from its first element on.
    fn views(
        &self,
        inputs: &Inputs,
        stored: &[usize],
        first: &dyn Fn(usize) -> TokenStream,
        (start, length): (&TokenStream, &TokenStream),
    ) -> TokenStream {
        let read = inputs.slots.iter().enumerate().map(|(input, slot)| {
            let (name, array, first) = (input_name(input), self.array(&slot.array), first(input));
            match inputs.orders[input] {
                IndexOrder::Constant => quote!(let #name = #array[#first];),
                IndexOrder::Consecutive => quote!(let #name = &#array[#first..#first + #length];),
                IndexOrder::Listed => {
                    let list = list_name(input);
                    quote!(let #name = &#list[#start..#start + #length];)
                }
            }
        });
        let written = stored.iter().map(|&kind| {
            let (array, output) = (self.array_name(kind), output_name(kind));
            quote!(let #output = &mut #array[#start..#start + #length];)
        });
        read.chain(written).collect()
    }

    /// The name of the array of a kind.
    fn array_name(&self, kind: usize) -> Ident {
        name(&format!("{}_cells", self.prefix), kind)
    }

    /// An array, to be read.
    fn array(&self, array: &Array) -> TokenStream {
        match array {
            Array::One(value) => self.operand(*value),
            Array::Argument(text) => self.arguments[text].clone(),
            Array::Kind(kind) => {
                let name = self.array_name(*kind);
                quote!(#name)
            }
        }
    }
}

/// The operands of some operations in one position; `None` if they are in different arrays.
fn slot_of(rows: &[(Vec<OperandPlace>, Value)], slot: usize) -> Option<Slot> {
    let array = match &rows[0].0[slot] {
        OperandPlace::One(value) => Array::One(*value),
        OperandPlace::Argument(text, _) => Array::Argument(text.clone()),
        OperandPlace::Member(kind, _) => Array::Kind(*kind),
    };
    let mut elements = Vec::new();
    for (parts, _) in rows {
        match (&parts[slot], &array) {
            (OperandPlace::One(value), Array::One(one)) if value == one => {}
            (OperandPlace::Argument(text, element), Array::Argument(known)) if text == known => {
                elements.push(*element);
            }
            (OperandPlace::Member(kind, element), Array::Kind(known)) if kind == known => {
                elements.push(*element);
            }
            _ => return None,
        }
    }
    Some(Slot { array, elements })
}

/// The order of most of the indices.
fn index_order(elements: &[usize]) -> IndexOrder {
    let count = |step: usize| {
        elements
            .windows(2)
            .filter(|pair| pair[0] + step == pair[1])
            .count()
    };
    let (same, next, all) = (count(0), count(1), elements.len());
    if 4 * same.max(next) < 3 * all.saturating_sub(1) {
        IndexOrder::Listed
    } else if same > next {
        IndexOrder::Constant
    } else {
        IndexOrder::Consecutive
    }
}

/// The cells at which runs begin; within a run, all indices follow their order.
fn run_starts(count: usize, inputs: &[&Slot], orders: &[IndexOrder]) -> Vec<usize> {
    let continues = |cell: &usize| {
        inputs.iter().zip(orders).all(|(slot, order)| {
            let [before, here] = [slot.elements[cell - 1], slot.elements[*cell]];
            match order {
                IndexOrder::Constant => here == before,
                IndexOrder::Consecutive => here == before + 1,
                IndexOrder::Listed => true,
            }
        })
    };
    let breaks = (1..count).filter(|cell| !continues(cell));
    std::iter::once(0).chain(breaks).collect()
}

/// The run starts ([`run_starts`]), with the order that suits each array best.
fn runs_of(count: usize, inputs: &[&Slot]) -> Vec<usize> {
    let inputs: Vec<&Slot> = inputs
        .iter()
        .copied()
        .filter(|slot| !slot.elements.is_empty())
        .collect();
    let orders: Vec<IndexOrder> = inputs.iter().map(|slot| index_order(&slot.elements)).collect();
    run_starts(count, &inputs, &orders)
}

/// A name that captures none of the user's.
fn name(prefix: &str, number: usize) -> Ident {
    Ident::new(&format!("{prefix}{number}"), Span::mixed_site())
}

/// The part of a kind's array that a run computes.
fn output_name(kind: usize) -> Ident {
    name("out", kind)
}

/// The value of one cell.
fn value_name(kind: usize) -> Ident {
    name("c", kind)
}

/// The slice that a run reads.
fn input_name(input: usize) -> Ident {
    name("in", input)
}

/// The index of its first element.
fn first_name(input: usize) -> Ident {
    name("first", input)
}

/// The list of indices of an input.
fn list_name(input: usize) -> Ident {
    name("LIST", input)
}
