//! From joints in any order to a valid tree: parents before children, joint `i` moves link `i + 1`.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Unit, Vector3};

use super::{Joint, JointKind, JointLimit, Link, Mimic, RobotError};

/// A joint as it stands in the file, its links still names.
pub(super) struct JointDraft {
    pub(super) line: u32,
    pub(super) name: String,
    pub(super) kind: JointKind,
    pub(super) parent: String,
    pub(super) child: String,
    pub(super) X_PJ: Isometry3<f64>,
    pub(super) axis: Unit<Vector3<f64>>,
    pub(super) limit: JointLimit,
    /// Joint that is copied, factor, offset.
    pub(super) mimic: Option<(String, f64, f64)>,
}

/// What a mimic follows: draft of the moving joint, factor, offset.
type Copied = (usize, f64, f64);

type Tree = (Vec<Link>, Vec<Joint>, Vec<usize>);

/// Orders links and joints. Joints keep the file's order wherever that already puts parents first.
pub(super) fn order_tree(links: Vec<(Link, u32)>, drafts: Vec<JointDraft>) -> Result<Tree, RobotError> {
    let index: BTreeMap<String, usize> =
        links.iter().enumerate().map(|(i, (link, _))| (link.name.clone(), i)).collect();
    let find = |draft: &JointDraft, name: &str| {
        index.get(name).copied().ok_or_else(|| RobotError::UnknownName {
            line: draft.line,
            thing: format!("joint {:?}", draft.name),
            kind: "link",
            name: name.to_owned(),
        })
    };
    let mut ends = Vec::with_capacity(drafts.len());
    let mut mover: Vec<Option<usize>> = vec![None; links.len()];
    for (i, draft) in drafts.iter().enumerate() {
        let (parent, child) = (find(draft, &draft.parent)?, find(draft, &draft.child)?);
        if let Some(first) = mover[child] {
            return Err(RobotError::TwoParents {
                line: draft.line,
                link: draft.child.clone(),
                first: drafts[first].name.clone(),
                second: draft.name.clone(),
            });
        }
        mover[child] = Some(i);
        ends.push((parent, child));
    }
    refuse_loops(&links, &drafts, &ends, &mover)?;

    let mut roots = (0..links.len()).filter(|&link| mover[link].is_none());
    let Some(root) = roots.next() else { return Err(RobotError::NoLinks) };
    if let Some(second) = roots.next() {
        let name = |link: usize| links[link].0.name.clone();
        return Err(RobotError::TwoRoots { line: links[second].1, first: name(root), second: name(second) });
    }

    // Every joint's ancestors go first; then the joint itself, once.
    let mut order = Vec::with_capacity(drafts.len());
    let mut placed = vec![false; drafts.len()];
    for start in 0..drafts.len() {
        let mut pending = Vec::new();
        let mut next = Some(start);
        while let Some(joint) = next.filter(|&joint| !placed[joint]) {
            placed[joint] = true;
            pending.push(joint);
            next = mover[ends[joint].0];
        }
        order.extend(pending.into_iter().rev());
    }

    let mut new_link = vec![0; links.len()];
    for (position, &joint) in order.iter().enumerate() {
        new_link[ends[joint].1] = position + 1;
    }
    let masters = resolve_mimics(&drafts)?;
    let mut dof_of_draft = vec![None; drafts.len()];
    let mut dof_joints = Vec::new();
    for (position, &joint) in order.iter().enumerate() {
        if drafts[joint].kind != JointKind::Fixed && masters[joint].is_none() {
            dof_of_draft[joint] = Some(dof_joints.len());
            dof_joints.push(position);
        }
    }
    let mimic = |joint: usize| {
        let (master, multiplier, offset) = masters[joint]?;
        Some(Mimic { dof: dof_of_draft[master]?, multiplier, offset })
    };
    let mimics: Vec<_> = (0..drafts.len()).map(mimic).collect();

    let mut slots: Vec<Option<JointDraft>> = drafts.into_iter().map(Some).collect();
    let joints = order
        .iter()
        .filter_map(|&i| slots[i].take().map(|draft| (i, draft)))
        .map(|(i, draft)| Joint {
            name: draft.name,
            kind: draft.kind,
            parent: new_link[ends[i].0],
            child: new_link[ends[i].1],
            X_PJ: draft.X_PJ,
            axis: draft.axis,
            limit: draft.limit,
            mimic: mimics[i],
            dof: dof_of_draft[i],
        })
        .collect();
    let mut numbered: Vec<(usize, Link)> =
        links.into_iter().enumerate().map(|(old, (link, _))| (new_link[old], link)).collect();
    numbered.sort_by_key(|(new, _)| *new);
    Ok((numbered.into_iter().map(|(_, link)| link).collect(), joints, dof_joints))
}

/// Follows parents from every joint; meeting the joint's own child again is a loop, reported at its last joint.
fn refuse_loops(
    links: &[(Link, u32)],
    drafts: &[JointDraft],
    ends: &[(usize, usize)],
    mover: &[Option<usize>],
) -> Result<(), RobotError> {
    let mut reported: Option<(u32, usize, Vec<usize>)> = None;
    for (closing, &(parent, child)) in ends.iter().enumerate() {
        let mut path = vec![child];
        let mut link = parent;
        while link != child && path.len() <= links.len() {
            path.push(link);
            match mover[link] {
                Some(joint) => link = ends[joint].0,
                None => break,
            }
        }
        if link == child {
            path.push(child);
            path.reverse();
            let line = drafts[closing].line;
            if reported.as_ref().is_none_or(|(known, ..)| line > *known) {
                reported = Some((line, closing, path));
            }
        }
    }
    match reported {
        None => Ok(()),
        Some((line, closing, path)) => Err(RobotError::Cycle {
            line,
            joint: drafts[closing].name.clone(),
            links: path.into_iter().map(|link| links[link].0.name.clone()).collect(),
        }),
    }
}

/// For every mimic joint: the moving joint at the end of its chain, with the composed factor and offset.
fn resolve_mimics(drafts: &[JointDraft]) -> Result<Vec<Option<Copied>>, RobotError> {
    let by_name: BTreeMap<&str, usize> = drafts.iter().enumerate().map(|(i, d)| (d.name.as_str(), i)).collect();
    let mut resolved = Vec::with_capacity(drafts.len());
    for draft in drafts {
        let refuse = |master: &str, reason| RobotError::BadMimic {
            line: draft.line,
            joint: draft.name.clone(),
            master: master.to_owned(),
            reason,
        };
        let (mut factor, mut offset) = (1.0, 0.0);
        let mut current = draft;
        let mut master = None;
        for _ in 0..=drafts.len() {
            let Some((name, next_factor, next_offset)) = &current.mimic else { break };
            let next = *by_name.get(name.as_str()).ok_or_else(|| refuse(name, "which does not exist"))?;
            offset += factor * next_offset;
            factor *= next_factor;
            current = &drafts[next];
            master = Some(next);
        }
        if let (Some((name, ..)), Some(_)) = (&current.mimic, master) {
            return Err(refuse(name, "which leads back to itself"));
        }
        if master.is_some() && current.kind == JointKind::Fixed {
            return Err(refuse(&current.name, "which is fixed"));
        }
        let moves = draft.kind != JointKind::Fixed;
        resolved.push(master.filter(|_| moves).map(|master| (master, factor, offset)));
    }
    Ok(resolved)
}
