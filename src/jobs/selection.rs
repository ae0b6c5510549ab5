//! Which outputs a client wants, out of those a process has.

use std::collections::BTreeMap;

use biotope_api::error::ErrorCode;
use biotope_api::execute::OutputChoice;

use crate::jobs::Invalid;
use crate::jobs::Output;

/// Outputs that are kept of every job.
pub const ALWAYS: [&str; 2] = ["manifest", "warnings"];

/// Which outputs are kept.
#[derive(Debug, Clone, Default)]
pub struct Selection {
    known: Vec<(&'static str, bool)>,
    chosen: Option<Vec<String>>,
}

impl Selection {
    /// The selection that `choice` makes out of `outputs`; `None` chooses the defaults.
    ///
    /// # Errors
    /// Every id that names no output; pointers are relative to the body.
    pub fn new(outputs: &[Output], choice: Option<&BTreeMap<String, OutputChoice>>) -> Result<Self, Invalid> {
        let known: Vec<_> = outputs.iter().map(|output| (output.id, output.default)).collect();
        let mut faults = Invalid::default();
        for id in choice.iter().flat_map(|choice| choice.keys()) {
            if !known.iter().any(|(pattern, _)| names(id, pattern)) {
                let ids: Vec<_> = known.iter().map(|(pattern, _)| *pattern).collect();
                let pointer = format!("/outputs/{}", id.replace('~', "~0").replace('/', "~1"));
                faults.push(pointer, ErrorCode::UnknownOutput, format!("one of {}", ids.join(", ")), id);
            }
        }
        faults.into_result()?;
        Ok(Self { known, chosen: choice.map(|choice| choice.keys().cloned().collect()) })
    }

    /// Whether the output `id` is to be kept. `manifest` and `warnings` always are.
    pub fn wants(&self, id: &str) -> bool {
        let chosen = match &self.chosen {
            Some(chosen) => chosen.iter().any(|wish| is_meant(wish, id)),
            None => self.known.iter().any(|(pattern, default)| *default && fits(id, pattern)),
        };
        chosen || ALWAYS.contains(&id)
    }

    /// Whether the process has such an output at all.
    pub fn knows(&self, id: &str) -> bool {
        self.known.iter().any(|(pattern, _)| fits(id, pattern))
    }
}

/// Whether a client's wish means the output `id`.
pub fn is_meant(wish: &str, id: &str) -> bool {
    wish == id || covers(wish, id) || fits(id, wish)
}

/// Whether a wish names outputs of `pattern`: the pattern itself, an id of its form, or `a.*`.
fn names(wish: &str, pattern: &str) -> bool {
    wish == pattern || fits(wish, pattern) || covers(wish, pattern)
}

/// Whether the wish is `<prefix>.*` and `id` lies below it.
fn covers(wish: &str, id: &str) -> bool {
    wish.strip_suffix('*').is_some_and(|prefix| prefix.ends_with('.') && id.starts_with(prefix))
}

/// Whether `id` is of the form of `pattern`, in which `<name>` stands for a part without dots.
pub fn fits(id: &str, pattern: &str) -> bool {
    let (mut parts, mut forms) = (id.split('.'), pattern.split('.'));
    loop {
        match (parts.next(), forms.next()) {
            (None, None) => return true,
            (Some(part), Some(form)) if part == form || (form.starts_with('<') && !part.is_empty()) => {}
            _ => return false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::jobs::artefact::Kind;

    fn outputs() -> Vec<Output> {
        vec![
            Output::new("soil", "Soil", "", Kind::Map),
            Output::new("climate.moisture.<mm>", "Moisture", "", Kind::Map).on_request(),
            Output::new("plants.cover.<slug>", "Cover", "", Kind::Map),
        ]
    }

    fn selection(ids: &[&str]) -> Result<Selection, Invalid> {
        let choice = ids.iter().map(|id| ((*id).to_owned(), OutputChoice::default())).collect();
        Selection::new(&outputs(), Some(&choice))
    }

    #[test]
    fn without_a_choice_the_defaults_are_kept() {
        let all = Selection::new(&outputs(), None).unwrap();
        assert!(all.wants("soil") && all.wants("plants.cover.quercus-ilex"));
        assert!(!all.wants("climate.moisture.01") && all.knows("climate.moisture.01"));
        assert!(!all.knows("plants.cover") && !all.knows("plants.cover."));
    }

    #[test]
    fn outputs_are_chosen_by_id_by_family_or_by_group() {
        let some = selection(&["plants.*", "climate.moisture.<mm>"]).unwrap();
        assert!(some.wants("plants.cover.quercus-ilex") && some.wants("climate.moisture.07") && !some.wants("soil"));
        let one = selection(&["plants.cover.quercus-ilex"]).unwrap();
        assert!(one.wants("plants.cover.quercus-ilex") && !one.wants("plants.cover.pinus"));
        assert!(!selection(&[]).unwrap().wants("soil"));
    }

    #[test]
    fn every_unknown_id_is_reported() {
        let faults = selection(&["soil", "sole", "plants.c*", "a/b"]).unwrap_err();
        let pointers: Vec<_> = faults.errors.iter().map(|e| e.pointer.as_str()).collect();
        assert_eq!(pointers, ["/outputs/a~1b", "/outputs/plants.c*", "/outputs/sole"]);
    }
}
