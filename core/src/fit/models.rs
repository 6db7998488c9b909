//! Which deformation pays: plain, tapered, bent or both, compared by the Bayesian information criterion.
//!
//! `BIC = n ln(MS + σ₀²) + k ln n` with MS the truncated mean square of the distances along the normal on the n points
//! of the coarse search, k the number of unknowns, and σ₀ = 1.5 mm: what lies below that, no depth camera at arm's
//! length could tell. The least value wins, but plain wins against a deformation that is less than 10 better (very strong
//! evidence by Kass and Raftery 1995).

use super::candidate::{BEND, Candidate, DEFORMED, PLAIN, TAPER};
use super::robust::{sigma_m, truncated_mean_square};
use super::search::Search;
use super::types::{DeformMode, FitRefusal, ModelReport};
use super::weighted::WeightedPoints;

/// σ₀ above, metres.
const NOISE_FLOOR_M: f64 = 0.0015;
/// By how much the criterion of a deformation must be lower than without it, per deformation.
const STRONG_EVIDENCE: f64 = 10.0;
/// Distances count up to this many σ of the plain fit.
const TRUNCATED_SIGMAS: f64 = 4.0;
/// Tapers and bends (in turns of the half length, radians) from which a deformed fit starts.
const START_TAPERS: [f64; 2] = [0.4, -0.4];
const START_BENDS_RAD: [f64; 2] = [0.4, -0.4];
/// Starts of a model that are followed further, and their rounds of new weights.
const KEPT: usize = 2;
const ROUNDS: usize = 3;

/// A deformation that may be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Model {
    Plain,
    Taper,
    Bend,
    Both,
}

impl Model {
    /// The models that a mode compares.
    pub(crate) fn of(mode: DeformMode) -> &'static [Self] {
        match mode {
            DeformMode::None => &[Self::Plain],
            DeformMode::Taper => &[Self::Taper],
            DeformMode::Bend => &[Self::Bend],
            DeformMode::Both => &[Self::Both],
            DeformMode::Auto => &[Self::Plain, Self::Taper, Self::Bend, Self::Both],
        }
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Taper => "taper",
            Self::Bend => "bend",
            Self::Both => "taper and bend",
        }
    }

    fn unknowns(self) -> f64 {
        match self {
            Self::Plain => PLAIN as f64,
            Self::Taper | Self::Bend => PLAIN as f64 + 1.0,
            Self::Both => DEFORMED as f64,
        }
    }

    /// What the criterion of this model must overcome.
    fn handicap(self) -> f64 {
        STRONG_EVIDENCE * self.frees().into_iter().filter(|is_free| *is_free).count() as f64
    }

    /// Which of taper and bend are free.
    pub(crate) fn frees(self) -> [bool; 2] {
        [matches!(self, Self::Taper | Self::Both), matches!(self, Self::Bend | Self::Both)]
    }
}

/// The criterion of a fit: mean square in m², σ₀ in metres, number of points, unknowns.
pub(crate) fn bic(mean_square: f64, floor_m: f64, points: usize, unknowns: f64) -> f64 {
    let n = points.max(1) as f64;
    n * crate::math::ln(mean_square + floor_m * floor_m) + unknowns * crate::math::ln(n)
}

/// The best model on the coarse points, from the plain shape that was found there.
///
/// # Errors
/// [`FitRefusal::Stopped`].
pub(crate) fn best_model(
    search: &mut Search<'_>,
    plain: Candidate,
    mode: DeformMode,
) -> Result<(Model, Candidate, Vec<ModelReport>), FitRefusal> {
    let models = Model::of(mode);
    if models == [Model::Plain] {
        return Ok((Model::Plain, plain, Vec::new()));
    }
    let coarse = search.coarse.clone();
    let laid_out = WeightedPoints::new(&coarse);
    let limit_m = TRUNCATED_SIGMAS * sigma_m(&laid_out.residuals(&plain)).max(NOISE_FLOOR_M);
    let mean_square = |candidate: &Candidate| truncated_mean_square(&laid_out.residuals(candidate), &coarse, limit_m);

    let mut reports = Vec::new();
    let mut best: Option<(f64, Model, Candidate)> = None;
    for &model in models {
        let mut found = (mean_square(&plain), plain);
        if model != Model::Plain {
            let starts = search.deformed_starts(&plain, model);
            let mut brief = Vec::with_capacity(starts.len());
            for start in starts {
                let candidate = search.deformed_brief(start, model);
                brief.push((mean_square(&candidate), candidate));
            }
            brief.sort_by(|(p, _), (q, _)| p.total_cmp(q)); // stable: equal starts keep their order
            let mut tried = Vec::with_capacity(KEPT);
            for (_, candidate) in brief.into_iter().take(KEPT) {
                let candidate = search.deformed(&coarse, candidate, model, ROUNDS, model.name())?;
                tried.push((mean_square(&candidate), candidate));
            }
            found = tried.into_iter().min_by(|(p, _), (q, _)| p.total_cmp(q)).unwrap_or(found);
        }
        let criterion = bic(found.0, NOISE_FLOOR_M, coarse.len(), model.unknowns()) + model.handicap();
        reports.push(ModelReport { name: model.name().to_owned(), criterion, rms_m: found.0.sqrt(), is_chosen: false });
        if best.as_ref().is_none_or(|(least, ..)| criterion < *least) {
            best = Some((criterion, model, found.1));
        }
    }
    let Some((_, model, candidate)) = best else { return Ok((Model::Plain, plain, reports)) };
    for report in &mut reports {
        report.is_chosen = report.name == model.name();
    }
    Ok((model, candidate, reports))
}

/// Every base bent towards either of its other axes and tapered either way.
pub(crate) fn deformed(bases: &[Candidate], model: Model) -> Vec<Candidate> {
    let [tapers, bends] = model.frees();
    let mut starts = Vec::new();
    for base in bases {
        let sides = if bends { vec![*base, quarter_turned(base)] } else { vec![*base] };
        for side in sides {
            for sense in 0..2 {
                let mut start = side;
                if bends {
                    start.values[BEND] = START_BENDS_RAD[sense] / side.axes()[2];
                } else if tapers {
                    start.values[TAPER] = START_TAPERS[sense];
                }
                starts.push(start);
            }
        }
    }
    starts
}

/// The same shape with x and y exchanged: the bend of a superquadric is always towards its own y.
fn quarter_turned(candidate: &Candidate) -> Candidate {
    let [a, b, c] = candidate.axes();
    let turn = nalgebra::UnitQuaternion::from_axis_angle(&nalgebra::Vector3::z_axis(), std::f64::consts::FRAC_PI_2);
    Candidate::new([b, a, c], candidate.exponents(), candidate.center(), candidate.R_DS * turn)
}
