//! What differs between two JSON documents, as a merge patch (RFC 7396).

use serde_json::{Map, Value};

/// The merge patch that turns `from` into `to`; `None` where no patch can, because `to` says `null` somewhere: in a
/// patch that removes a member.
pub(super) fn difference(from: &Value, to: &Value) -> Option<Value> {
    let patch = changes(from, to);
    (merged(from, &patch) == *to).then_some(patch)
}

fn changes(from: &Value, to: &Value) -> Value {
    let (Value::Object(from), Value::Object(to)) = (from, to) else { return to.clone() };
    let mut patch = Map::new();
    for (name, value) in to {
        match from.get(name) {
            Some(before) if before == value => {}
            Some(before) => {
                patch.insert(name.clone(), changes(before, value));
            }
            None => {
                patch.insert(name.clone(), value.clone());
            }
        }
    }
    for name in from.keys().filter(|name| !to.contains_key(*name)) {
        patch.insert(name.clone(), Value::Null);
    }
    Value::Object(patch)
}

/// `MergePatch(target, patch)` of RFC 7396, section 2.
pub(super) fn merged(target: &Value, patch: &Value) -> Value {
    let Value::Object(patch) = patch else { return patch.clone() };
    let mut target = target.as_object().cloned().unwrap_or_default();
    for (name, value) in patch {
        if value.is_null() {
            target.remove(name);
        } else {
            let before = target.get(name).unwrap_or(&Value::Null);
            let after = merged(before, value);
            target.insert(name.clone(), after);
        }
    }
    Value::Object(target)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn patches_merge_as_in_the_appendix_of_rfc_7396() {
        for (target, patch, result) in [
            (json!({"a": "b"}), json!({"a": "c"}), json!({"a": "c"})),
            (json!({"a": "b"}), json!({"b": "c"}), json!({"a": "b", "b": "c"})),
            (json!({"a": "b"}), json!({"a": null}), json!({})),
            (json!({"a": "b", "b": "c"}), json!({"a": null}), json!({"b": "c"})),
            (json!({"a": ["b"]}), json!({"a": "c"}), json!({"a": "c"})),
            (json!({"a": "c"}), json!({"a": ["b"]}), json!({"a": ["b"]})),
            (json!({"a": {"b": "c"}}), json!({"a": {"b": "d", "c": null}}), json!({"a": {"b": "d"}})),
            (json!({"a": [{"b": "c"}]}), json!({"a": [1]}), json!({"a": [1]})),
            (json!(["a", "b"]), json!(["c", "d"]), json!(["c", "d"])),
            (json!({"a": "b"}), json!(["c"]), json!(["c"])),
            (json!({"a": "foo"}), json!(null), json!(null)),
            (json!({"a": "foo"}), json!("bar"), json!("bar")),
            (json!({"e": null}), json!({"a": 1}), json!({"e": null, "a": 1})),
            (json!([1, 2]), json!({"a": "b", "c": null}), json!({"a": "b"})),
            (json!({}), json!({"a": {"bb": {"ccc": null}}}), json!({"a": {"bb": {}}})),
        ] {
            assert_eq!(merged(&target, &patch), result, "{target} with {patch}");
        }
    }

    #[test]
    fn a_difference_holds_no_more_than_what_differs_and_leads_there() {
        let from = json!({"a": {"b": 1, "c": [1, 2], "d": 2.5}, "e": "kept", "f": 3});
        let to = json!({"a": {"b": 1, "c": [1, 3], "d": 2.5}, "e": "kept", "g": {"h": 4}});
        let patch = difference(&from, &to).unwrap();
        assert_eq!(patch, json!({"a": {"c": [1, 3]}, "f": null, "g": {"h": 4}}));
        assert_eq!(merged(&from, &patch), to);
        assert_eq!(difference(&from, &from), Some(json!({})));
    }

    #[test]
    fn where_null_is_a_value_there_is_no_patch() {
        assert_eq!(difference(&json!({"a": 1}), &json!({"a": null})), None);
        assert_eq!(difference(&json!({}), &json!({"a": {"b": null}})), None);
        // One that stays is no matter, and neither is one in a list.
        assert!(difference(&json!({"a": null, "b": 1}), &json!({"a": null, "b": [null]})).is_some());
    }
}
