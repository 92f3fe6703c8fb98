//! The composition tree of the 2014 method as a list (section 4.1): bulges below, contacts on top.
//!
//! Every node of such a tree has a single field, or a group of fields joined by bulges, as its right child. So a walk over the
//! leaves evaluates it with two accumulators, the group's and the total, and no stack; and since g(f, 0) = f, leaves that do
//! not reach a point may be left out of the walk there.

use super::{Composition, Controller, Operator};

/// One field of a [`Fold`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leaf {
    /// Row of the field.
    pub field: u32,
    /// Number of its group; leaves of a group follow each other.
    pub group: u32,
    /// How it meets the leaves of its group before it.
    pub operator: Operator,
    /// Depth of that meeting.
    pub controller: Controller,
    /// Depth of the contact between its whole group and all groups before.
    pub group_controller: Controller,
}

/// Leaves in the order of their walk: groups by their first field, fields depth first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fold {
    /// The leaves.
    pub leaves: Vec<Leaf>,
}

impl Fold {
    /// The fold of a composition.
    pub fn new(composition: &Composition) -> Self {
        let order = depth_first(composition);
        let mut groups: Vec<(u32, Vec<u32>)> = Vec::new();
        for field in order {
            let parent = composition.parent[field as usize];
            let own = (parent != u32::MAX && joins(composition, field))
                .then(|| groups.iter_mut().find(|g| g.1.contains(&parent)))
                .flatten();
            match own {
                Some(group) => group.1.push(field),
                None => groups.push((field, vec![field])),
            }
        }
        let leaf = |number: usize, first: u32, field: u32| Leaf {
            field,
            group: number as u32,
            operator: operator(composition, field),
            controller: controller(composition, field),
            group_controller: controller(composition, first),
        };
        let leaves = groups
            .iter()
            .enumerate()
            .flat_map(|(number, (first, fields))| {
                fields.iter().map(move |f| leaf(number, *first, *f))
            });
        Self {
            leaves: leaves.collect(),
        }
    }

    /// Some group has more than one field.
    pub fn has_groups(&self) -> bool {
        self.leaves.windows(2).any(|w| w[0].group == w[1].group)
    }
}

fn operator(composition: &Composition, field: u32) -> Operator {
    composition.operator[field as usize].unwrap_or(Operator::Contact)
}

fn controller(composition: &Composition, field: u32) -> Controller {
    let own = composition.controller[field as usize];
    own.unwrap_or_else(|| operator(composition, field).default_controller())
}

/// Bulges and profiles join pairs at the bottom of the tree.
fn below(composition: &Composition, field: u32) -> bool {
    matches!(
        operator(composition, field),
        Operator::Bulge | Operator::Profile
    )
}

/// A field goes into its parent's group. A primitive does where there is one besides: what bulges there has to meet it, too.
fn joins(composition: &Composition, field: u32) -> bool {
    if !composition.is_primitive(field) {
        return below(composition, field);
    }
    let parent = composition.parent[field as usize];
    let child = |f: u32| composition.parent[f as usize] == parent && below(composition, f);
    below(composition, parent) || (0..composition.parent.len() as u32).any(child)
}

/// Fields depth first; of siblings the primitives first, so that they are one with their parent, the others ascending.
fn depth_first(composition: &Composition) -> Vec<u32> {
    let parent = &composition.parent;
    let joints = (parent.len() - composition.primitives) as u32;
    let children = |of: u32| {
        let all = (joints..parent.len() as u32).chain(0..joints);
        all.filter(move |f| parent[*f as usize] == of)
    };
    let mut order = Vec::with_capacity(parent.len());
    let mut open: Vec<u32> = children(u32::MAX).collect();
    open.reverse();
    while let Some(field) = open.pop() {
        order.push(field);
        let first = open.len();
        open.extend(children(field));
        open[first..].reverse();
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A palm (0), two fingers of two bones each (1, 3 and 2, 4), and a bone of its own (5).
    fn hand(bulges: &[usize]) -> Composition {
        let mut operator = vec![None; 6];
        for b in bulges {
            operator[*b] = Some(Operator::Bulge);
        }
        Composition {
            parent: vec![u32::MAX, 0, 0, 1, 2, u32::MAX],
            primitives: 0,
            operator,
            opening: vec![None; 6],
            controller: vec![None; 6],
            profile: None,
            magnitude: 1.0,
        }
    }

    fn walk(composition: &Composition) -> Vec<(u32, u32)> {
        let leaves = Fold::new(composition).leaves;
        leaves.iter().map(|l| (l.field, l.group)).collect()
    }

    #[test]
    fn contacts_alone_go_depth_first() {
        let fields: Vec<u32> = walk(&hand(&[])).iter().map(|l| l.0).collect();
        assert_eq!(fields, [0, 1, 3, 2, 4, 5]);
        assert!(!Fold::new(&hand(&[])).has_groups());
    }

    #[test]
    fn bulges_gather_their_chain_below_the_contacts() {
        let tips = hand(&[3, 4]);
        assert_eq!(
            walk(&tips),
            [(0, 0), (1, 1), (3, 1), (2, 2), (4, 2), (5, 3)]
        );
        let all = hand(&[1, 2, 3, 4]);
        assert_eq!(walk(&all), [(0, 0), (1, 0), (3, 0), (2, 0), (4, 0), (5, 1)]);
        assert!(Fold::new(&all).has_groups());
    }

    #[test]
    fn a_primitive_follows_its_field_and_joins_a_group_only_where_there_is_one() {
        let mut alone = hand(&[]);
        alone.add_primitive(1);
        assert_eq!(
            walk(&alone),
            [(0, 0), (1, 1), (6, 2), (3, 3), (2, 4), (4, 5), (5, 6)]
        );
        assert!(!Fold::new(&alone).has_groups());
        let mut tips = hand(&[3, 4]);
        tips.add_primitive(1);
        let fold = Fold::new(&tips);
        assert_eq!(
            walk(&tips)[..4],
            [(0, 0), (1, 1), (6, 1), (3, 1)],
            "the tip bulges against the primitive"
        );
        assert_eq!(fold.leaves[2].controller, Controller::never());
        assert_eq!(fold.leaves[2].group_controller, Controller::fold());
    }

    #[test]
    fn a_group_meets_the_rest_by_its_first_fields_controller() {
        let mut tips = hand(&[3, 4]);
        tips.controller[1] = Some(Controller::never());
        let fold = Fold::new(&tips);
        assert_eq!(fold.leaves[2].controller, Controller::finger());
        assert_eq!(fold.leaves[2].group_controller, Controller::never());
        assert_eq!(fold.leaves[4].group_controller, Controller::fold());
    }
}
