//! The order in which a variant's text is read: constants that everything shares, what a host sets and binds, the entry
//! points, then what they call.
//!
//! WGSL takes declarations in any order. Below the entry points stands module by module what they reach, as the author has
//! ordered it within a module; a module comes after those that use it, the first one that is named first.

use std::collections::HashSet;

use crate::assemble::{Assembled, Order, Piece};
use crate::parse::{Declaration, Kind};

/// The pieces that `keep` marks, in the order in which a person reads them, from `entry_points` on.
pub(crate) fn of_reading(
    assembled: &Assembled<'_>,
    keep: &[bool],
    entry_points: &[String],
) -> Order {
    let pieces = assembled.pieces();
    let declaration = |piece: usize| assembled.declaration(&pieces[piece]);
    let kept = || (0..pieces.len()).filter(|piece| keep[*piece]);
    let mut placed = Placed { assembled, keep, order: Vec::new(), seen: HashSet::new() };
    for piece in kept() {
        if placed.is_of_constants(pieces[piece].module) {
            placed.place(piece);
        }
    }
    for piece in kept().filter(|piece| declaration(*piece).kind == Kind::Override) {
        placed.place(piece);
    }
    let mut bound: Vec<_> = kept().filter(|piece| declaration(*piece).binding.is_some()).collect();
    bound.sort_by_key(|piece| declaration(*piece).binding);
    for piece in &bound {
        placed.place_named(*piece, |_| true);
    }
    for piece in bound {
        placed.place(piece);
    }
    for piece in kept().filter(|piece| declaration(*piece).kind == Kind::Variable) {
        placed.place(piece);
    }
    let entry_points: Vec<_> =
        entry_points.iter().filter_map(|name| assembled.find(name)).collect();
    for piece in &entry_points {
        let body = declaration(*piece).body;
        placed.place_named(*piece, |at| at < body);
    }
    for piece in &entry_points {
        placed.place(*piece);
    }
    let interface = placed.order.len();
    for module in placed.modules(&entry_points) {
        for piece in kept().filter(|piece| pieces[*piece].module == module) {
            if placed.seen.insert(piece) {
                placed.order.push(piece);
            }
        }
    }
    Order { pieces: placed.order, interface }
}

struct Placed<'a> {
    assembled: &'a Assembled<'a>,
    keep: &'a [bool],
    order: Vec<usize>,
    seen: HashSet<usize>,
}

impl Placed<'_> {
    fn piece(&self, index: usize) -> (&Piece, &Declaration) {
        let piece = &self.assembled.pieces()[index];
        (piece, self.assembled.declaration(piece))
    }

    /// Whether a module declares constants and nothing else.
    fn is_of_constants(&self, module: usize) -> bool {
        let of_module = |piece: &&Piece| piece.module == module;
        let mut pieces = self.assembled.pieces().iter().filter(of_module);
        pieces.all(|piece| self.assembled.declaration(piece).kind == Kind::Constant)
    }

    /// A piece behind the types and numbers that it names outside of a function's block.
    fn place(&mut self, index: usize) {
        if self.seen.insert(index) {
            let body = self.piece(index).1.body;
            self.place_named(index, |at| at < body);
            self.order.push(index);
        }
    }

    /// The types and numbers that a piece names at places for which `counts` says so.
    fn place_named(&mut self, index: usize, counts: impl Fn(usize) -> bool) {
        let named: Vec<_> =
            self.piece(index).0.names.iter().filter(|(at, _)| counts(*at)).collect();
        let named: Vec<_> = named.into_iter().map(|(_, piece)| *piece).collect();
        for piece in named {
            let kind = self.piece(piece).1.kind;
            if matches!(kind, Kind::Struct | Kind::Alias | Kind::Constant | Kind::Override)
                && self.keep[piece]
            {
                self.place(piece);
            }
        }
    }

    /// The modules of the pieces that are kept, each after those that use it; first those of `entry_points`.
    fn modules(&self, entry_points: &[usize]) -> Vec<usize> {
        let (mut seen, mut order) = (HashSet::new(), Vec::new());
        for piece in entry_points.iter().rev() {
            self.visit(self.piece(*piece).0.module, &mut seen, &mut order);
        }
        order.reverse();
        for piece in (0..self.keep.len()).filter(|piece| self.keep[*piece]) {
            let module = self.piece(piece).0.module;
            if seen.insert(module) {
                order.push(module);
            }
        }
        order
    }

    /// Appends `module` behind all that its functions use, of those what is named last first.
    fn visit(&self, module: usize, seen: &mut HashSet<usize>, order: &mut Vec<usize>) {
        if !seen.insert(module) {
            return;
        }
        let own = (0..self.keep.len()).filter(|piece| self.keep[*piece]);
        let own = own.map(|piece| self.piece(piece)).filter(|(piece, declaration)| {
            piece.module == module && matches!(declaration.kind, Kind::Function | Kind::EntryPoint)
        });
        let named = own.flat_map(|(piece, _)| &piece.names);
        let mut used: Vec<usize> = Vec::new();
        for (_, piece) in named {
            let module = self.piece(*piece).0.module;
            if !used.contains(&module) {
                used.push(module);
            }
        }
        for module in used.into_iter().rev() {
            self.visit(module, seen, order);
        }
        order.push(module);
    }
}
