//! What is compared, and by which budgets: chosen once.

use std::sync::OnceLock;
use std::time::Duration;

use super::contender::{CONTENDERS, CUT_OFF, Contender, DEFAULT, DEPTH_FIRST, ORACLE, WARM};

/// The choices of a sweep.
#[derive(Clone)]
pub struct Plan {
    /// Of [`others`], those to compare with the default and with depth-first, which are always measured.
    pub orders: Vec<String>,
    /// Budgets of work, in percent of the work of a full search at the same pose.
    pub work_percent: Vec<u32>,
    /// Budgets of time in microseconds.
    pub time_us: Vec<u64>,
}

static PLAN: OnceLock<Plan> = OnceLock::new();

/// The choices of this run.
pub fn plan() -> &'static Plan {
    PLAN.get().expect("chosen before anything is measured")
}

/// The orders that can be left out of a sweep.
pub fn others() -> Vec<&'static str> {
    CONTENDERS
        .iter()
        .map(|contender| contender.name)
        .filter(|name| ![DEFAULT, DEPTH_FIRST].contains(name))
        .collect()
}

impl Plan {
    /// Makes these the choices of this run.
    pub fn choose(&self) {
        let mut plan = self.clone();
        plan.work_percent.sort_unstable();
        plan.work_percent.dedup();
        plan.time_us.sort_unstable();
        plan.time_us.dedup();
        // The first choice of a run stays.
        let _ = PLAN.set(plan);
    }

    /// Whom to measure: the default first, depth-first second.
    pub fn contenders(&self) -> impl Iterator<Item = &'static Contender> + Clone {
        let is_chosen = |name| {
            [DEFAULT, DEPTH_FIRST].contains(&name) || self.orders.iter().any(|order| order == name)
        };
        CONTENDERS
            .iter()
            .filter(move |contender| is_chosen(contender.name))
    }

    /// All that is compared under budgets of work.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.contenders()
            .map(|contender| contender.name)
            .chain([ORACLE, CUT_OFF, WARM])
    }

    /// Budgets of work in percent, ascending.
    pub fn percent(&self) -> impl Iterator<Item = u32> + Clone {
        self.work_percent.iter().copied()
    }

    /// The budget of work nearest to a percentage: what is put in words.
    pub fn percent_near(&self, percent: u32) -> u32 {
        self.percent()
            .min_by_key(|chosen| chosen.abs_diff(percent))
            .unwrap_or(percent)
    }

    /// Budgets of time, ascending.
    pub fn times(&self) -> impl Iterator<Item = Duration> {
        self.time_us.iter().copied().map(Duration::from_micros)
    }

    /// All that is compared under budgets of time.
    pub fn timed_names(&self) -> impl Iterator<Item = &'static str> {
        self.contenders().map(|contender| contender.name)
    }
}
