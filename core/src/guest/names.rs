//! What names of links and joints tell about the part of a robot that they belong to.

/// Words that only legs, heads and wheels bear.
const NO_ARM: [&str; 9] = ["hip", "knee", "ankle", "foot", "leg", "toe", "wheel", "head", "neck"];
/// Words of a frame that is meant as the end of an arm, most telling first.
const TIPS: [&str; 8] = ["tcp", "tool0", "tool", "grasp", "ee", "flange", "hand", "tip"];

/// The words of a name, in lower case: `l_hipPitch_joint` has `l`, `hip`, `pitch`, `joint`.
pub(super) fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut before = ' ';
    for letter in name.chars() {
        let is_new = !letter.is_alphanumeric() || letter.is_uppercase() && before.is_lowercase();
        if is_new {
            words.push(String::new());
        }
        if letter.is_alphanumeric()
            && let Some(word) = words.last_mut()
        {
            word.extend(letter.to_lowercase());
        }
        before = letter;
    }
    words.retain(|word| !word.is_empty());
    words
}

/// The word that says that something is no arm.
pub(super) fn no_arm(name: &str) -> Option<&'static str> {
    let words = words(name);
    NO_ARM.into_iter().find(|known| words.iter().any(|word| word == known))
}

/// How clearly a name says that a frame is the end of an arm; 0 where it does not.
pub(super) fn tip_rank(name: &str) -> usize {
    let words = words(name);
    let said = TIPS.iter().position(|known| words.iter().any(|word| word == known));
    said.map_or(0, |index| TIPS.len() - index)
}

/// On which side the name says that something is: -1 right, 1 left.
pub(super) fn side(name: &str) -> i32 {
    let words = words(name);
    let is_said = |known: [&str; 2]| words.iter().any(|word| known.contains(&word.as_str()));
    i32::from(is_said(["left", "l"])) - i32::from(is_said(["right", "r"]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_told_apart_by_marks_and_capitals() {
        assert_eq!(words("l_hipPitch-joint 2"), ["l", "hip", "pitch", "joint", "2"]);
        assert_eq!(no_arm("LeftHipPitch"), Some("hip"));
        assert_eq!(no_arm("shoulder_chip"), None);
        assert_eq!((side("right_arm_base"), side("arm_l"), side("flange")), (-1, 1, 0));
        assert!(tip_rank("tool0") > tip_rank("wrist_flange") && tip_rank("wrist_3_link") == 0);
    }
}
