//! The motion to the node up to which a run was watched.

use super::{AnyEvents, AnyObserver, AnyOccurrence, AnyPolynomial, Clock, RunError, Search, StepEnd};
use crate::number::compensated::Compensated;
use crate::series::rows::Series;
use crate::tape::declaration::Declaration;

/// The motion to the node up to which a run was watched. It is needed because an event at the node itself is
/// not inside a single leg, and because an event may have ended the run before the node.
///
/// A run that continues from another node ignores it.
#[derive(Clone, Debug)]
pub struct LastLeg {
    /// The series of the step, its time of expansion, and how it is searched.
    series: Series,
    t: Compensated<1>,
    search: Search,
    /// The arguments that rest at its ends.
    resting: [Vec<bool>; 2],
    /// The part that has not been searched yet, from its beginning to its end.
    span: [f64; 2],
    /// Whether a part has not been searched.
    is_left: bool,
    /// The number and the time of the node at its end; `None` if nothing was watched yet.
    stands: Option<(u64, f64)>,
}

impl Default for LastLeg {
    fn default() -> Self {
        Self {
            series: Series::new(0, AnyPolynomial::ORDER),
            t: Compensated::exact([0.0]),
            search: Search::NODES,
            resting: [Vec::new(), Vec::new()],
            span: [0.0; 2],
            is_left: false,
            stands: None,
        }
    }
}

impl LastLeg {
    /// Takes a polynomial that was searched, up to an event that ended the run and those within the time
    /// `together` after it.
    pub(super) fn take(&mut self, polynomial: &AnyPolynomial<'_>, end: Option<f64>, together: f64) {
        self.series.clone_from(polynomial.series);
        (self.t, self.search) = (polynomial.t, polynomial.search);
        for (own, resting) in self.resting.iter_mut().zip(polynomial.resting) {
            resting.clone_into(own);
        }
        let from = end.map_or(polynomial.from, |s| s + together.copysign(polynomial.length()));
        self.span = [from, polynomial.to];
        self.is_left = end.is_some() && (polynomial.to - from) * polynomial.length() > 0.0;
        self.stands = None;
    }

    /// The polynomial, or its part that has not been searched.
    fn polynomial(&self) -> AnyPolynomial<'_> {
        let [from, to] = self.span;
        AnyPolynomial {
            series: &self.series,
            t: self.t,
            from,
            to,
            search: self.search,
            resting: [&self.resting[0], &self.resting[1]],
        }
    }
}

impl AnyEvents<'_> {
    /// Records the node at the end of a step.
    pub(super) fn stand(&mut self, clock: &Clock, end: StepEnd) {
        // if the run ended at an event, no part of a leg is left, and the zeros there have been reported
        self.leg.stands = (end != StepEnd::AtStop).then(|| (clock.index(), clock.time()));
    }

    /// Reports the events on the rest of the step in which an event ended the run, if the run has not moved
    /// since; or takes the signs of functions from that step.
    pub(super) fn resume(
        &mut self,
        declaration: &Declaration<'_>,
        clock: &Clock,
        observer: &mut dyn AnyObserver,
    ) -> Result<Option<AnyOccurrence>, RunError> {
        if self.leg.stands != Some((clock.index(), clock.time())) {
            return Ok(None);
        }
        let leg = self.leg.clone();
        if !leg.is_left {
            self.begin_after(declaration, &leg.polynomial())?;
            return Ok(None);
        }
        let ended = self.happen(declaration, &leg.polynomial(), observer)?;
        self.leg.stands = leg.stands;
        Ok(ended.map(|(_, occurrence)| occurrence))
    }
}

#[cfg(all(test, feature = "text"))]
mod tests {
    use super::*;
    use crate::number::point::AnyPoint;
    use crate::run::{AnyEvent, Run};
    use crate::series::jet::Jet;
    use crate::taylor::AnyTaylorFlow;
    use crate::text::Text;
    use crate::{AnyComposedFlow, AnyFlow, AnyStart, Composition, Tolerance};

    /// Events of a particle at unit speed at given places.
    fn places<'e>(places: &[(f64, bool)]) -> Vec<AnyEvent<'e>> {
        let event = |&(place, ends): &(f64, bool)| {
            let event = AnyEvent::function(move |at: AnyPoint<'_, Jet>| at.q[0] - place);
            if ends { event.terminal() } else { event }
        };
        places.iter().map(event).collect()
    }

    /// Collects the times of events.
    struct Times<'t>(&'t mut Vec<f64>);

    impl AnyObserver for Times<'_> {
        fn node(&mut self, _: &dyn Run) -> core::ops::ControlFlow<()> {
            core::ops::ControlFlow::Continue(())
        }

        fn event(&mut self, occurrence: &AnyOccurrence) -> core::ops::ControlFlow<()> {
            self.0.push(occurrence.point().t);
            core::ops::ControlFlow::Continue(())
        }
    }

    /// Checks a run of each method.
    fn with_every_method(check: impl Fn(&mut dyn Run)) {
        let text = "coordinates(x); lagrangian = dot(x).powi(2) / 2;";
        let text = Text::parse("particle", text).unwrap();
        let (system, start) = (&text.system, AnyStart::second_order(&[0.0], &[1.0]));
        check(AnyFlow::new(system, 0.1, &start).unwrap().run_mut());
        let method = Composition::SUZUKI_4;
        check(
            AnyComposedFlow::new(system, 0.1, method, &start)
                .unwrap()
                .run_mut(),
        );
        let series = AnyTaylorFlow::of_tape(system, &start, Tolerance::relative(1e-12)).unwrap();
        check(&mut series.every(0.1).unwrap());
    }

    #[test]
    fn an_event_at_a_node_between_two_watches_is_told_once() {
        for split in [1.0, 0.5, 0.95, 0.3] {
            with_every_method(|run| {
                let mut times = Vec::new();
                let mut leg = LastLeg::default();
                for end in [split, 2.0] {
                    let watched = places(&[(1.0, false), (0.5, false), (0.3, false)]);
                    let mut events = AnyEvents::new(watched).after(leg);
                    run.watch(end, &mut events, &mut Times(&mut times)).unwrap();
                    leg = events.last_leg();
                }
                assert_eq!(times.len(), 3, "{split}: {times:?}");
            });
        }
    }

    #[test]
    fn what_happens_behind_an_event_that_ends_a_run_is_told_by_the_next_watch() {
        with_every_method(|run| {
            let mut times = Vec::new();
            let mut events = AnyEvents::new(places(&[
                (0.52, false),
                (0.55, true),
                (0.55, false),
                (0.58, false),
            ]));
            let ended = run.watch(2.0, &mut events, &mut Times(&mut times)).unwrap();
            // events at the time of the terminal one come before it
            assert_eq!(ended.map(|end| end.event), Some(1));
            assert_eq!(times.len(), 3, "{times:?}");
            let others = places(&[(0.52, false), (0.57, true), (0.58, false), (0.7, false)]);
            let mut events = AnyEvents::new(others).after(events.last_leg());
            times.clear();
            let ended = run.watch(2.0, &mut events, &mut Times(&mut times)).unwrap();
            assert_eq!(ended.map(|end| end.event), Some(1));
            run.watch(2.0, &mut events, &mut Times(&mut times)).unwrap();
            for (time, exact) in times.iter().zip([0.57, 0.58, 0.7]) {
                assert!((time - exact).abs() < 1e-12, "{times:?}");
            }
            assert_eq!(times.len(), 3, "{times:?}");
        });
    }

    #[test]
    fn a_run_that_went_on_elsewhere_does_not_look_back() {
        with_every_method(|run| {
            let mut times = Vec::new();
            let mut events = AnyEvents::new(places(&[(0.55, true), (0.58, false)]));
            run.watch(2.0, &mut events, &mut Times(&mut times)).unwrap();
            run.to(1.0).unwrap();
            let mut events = AnyEvents::new(places(&[(0.58, false), (1.25, false)])).after(events.last_leg());
            times.clear();
            run.watch(2.0, &mut events, &mut Times(&mut times)).unwrap();
            assert_eq!(times.len(), 1, "{times:?}");
        });
    }
}
