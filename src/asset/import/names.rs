//! Unique names.

use std::collections::HashMap;

/// Hands out names, each once.
#[derive(Default)]
pub(super) struct Names {
    /// Each name handed out, and the number to try next behind it.
    taken: HashMap<String, usize>,
}

impl Names {
    /// `name`, or `fallback` where it has none, with `_2`, `_3`, … appended where it is taken.
    pub(super) fn unique(
        &mut self,
        name: Option<&str>,
        fallback: impl FnOnce() -> String,
    ) -> String {
        let name = match name {
            Some(name) if !name.is_empty() => name.to_owned(),
            _ => fallback(),
        };
        let mut free = name.clone();
        let mut number = self.taken.get(&name).copied().unwrap_or(2);
        while self.taken.contains_key(&free) {
            free = format!("{name}_{number}");
            number += 1;
        }
        self.taken.insert(free.clone(), 2);
        self.taken.insert(name, number);
        free
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_handed_out_once() {
        let mut names = Names::default();
        let mut next = |name| names.unique(name, || "joint_0".into());
        assert_eq!(next(Some("a")), "a");
        assert_eq!(next(Some("a_2")), "a_2");
        assert_eq!(next(Some("a")), "a_3");
        assert_eq!(next(None), "joint_0");
        assert_eq!(next(Some("")), "joint_0_2");
    }
}
