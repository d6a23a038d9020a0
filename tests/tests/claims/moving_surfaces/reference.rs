//! Reference motions with dry friction, from event to event: between events by the classical Runge–Kutta
//! method of order 4 with tiny steps, to each event by bisection, and from there in the only modes that are
//! consistent. It shares no code with the project.

use dsocs_tests::scenes::elimination::Decomposed;

/// Bodies and surfaces: `M(q) a = F(t, q, v) - Σ sₖ μₖ(|gₖ|) Dₖ` with the slips `gₖ = Dₖ v - wₖ(t, q)`; `sₖ`
/// is the sign of `gₖ`, or the value that keeps it zero.
pub(super) trait Scene<const N: usize> {
    fn mass(&self, q: &[f64; N]) -> [[f64; N]; N];
    fn force(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> [f64; N];
    fn contacts(&self) -> usize;
    fn direction(&self, k: usize) -> [f64; N];
    /// The speed of a surface, and its derivatives by the time and by the position.
    fn surface(&self, k: usize, t: f64, q: &[f64; N]) -> (f64, f64, [f64; N]);
    fn limit(&self, k: usize, slip: f64) -> f64;
}

#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Mode {
    Sticks,
    Slips(f64),
}

#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Kind {
    Stop,
    Release,
    Crossing,
}

type State<const N: usize> = ([f64; N], [f64; N]);

struct Piece<const N: usize> {
    t: [f64; 2],
    q: [[f64; N]; 2],
    v: [[f64; N]; 2],
    a: [[f64; N]; 2],
}

pub(super) struct Motion<const N: usize> {
    pieces: Vec<Piece<N>>,
    pub(super) events: Vec<(f64, usize, Kind)>,
    /// The smallest of these distances, at each of which the sequence of events would be another one: of
    /// slips and friction from an event that does not happen, of the modes from other ones, and of an event's
    /// rate from zero.
    pub(super) margin: f64,
    /// Whether each contact sticks at the end.
    pub(super) sticks: Vec<bool>,
}

fn dot<const N: usize>(x: &[f64; N], y: &[f64; N]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

pub(super) struct Reference<'s, S, const N: usize>(pub(super) &'s S);

impl<S: Scene<N>, const N: usize> Reference<'_, S, N> {
    fn slip(&self, k: usize, t: f64, (q, v): &State<N>) -> f64 {
        dot(&self.0.direction(k), v) - self.0.surface(k, t, q).0
    }

    /// Accelerations, friction coefficients `s`, and the rates of the slips.
    fn accelerations(
        &self,
        modes: &[Mode],
        t: f64,
        state: &State<N>,
    ) -> Option<([f64; N], Vec<f64>, Vec<f64>)> {
        let (s, (q, v)) = (self.0, state);
        let (mass, mut force) = (s.mass(q), s.force(t, q, v));
        let mut stuck = Vec::new();
        let mut frictions = vec![0.0; modes.len()];
        let drift = |k: usize| {
            let (_, by_time, by_place) = s.surface(k, t, q);
            by_time + dot(&by_place, v)
        };
        for (k, mode) in modes.iter().enumerate() {
            match mode {
                Mode::Sticks => stuck.push(k),
                Mode::Slips(side) => {
                    frictions[k] = -side * s.limit(k, side * self.slip(k, t, state));
                    let d = s.direction(k);
                    for i in 0..N {
                        force[i] += frictions[k] * d[i];
                    }
                }
            }
        }
        let m = stuck.len();
        let mut matrix = vec![vec![0.0; N + m]; N + m];
        let mut right = force.to_vec();
        for i in 0..N {
            matrix[i][..N].copy_from_slice(&mass[i]);
        }
        for (j, &k) in stuck.iter().enumerate() {
            let d = s.direction(k);
            for i in 0..N {
                matrix[i][N + j] = -d[i];
                matrix[N + j][i] = d[i];
            }
            right.push(drift(k));
        }
        let decomposed = Decomposed::new(matrix)?;
        if decomposed.smallest_pivot() < 1e-12 {
            return None;
        }
        let found = decomposed.solve(&right);
        let mut a = [0.0; N];
        a.copy_from_slice(&found[..N]);
        for (j, &k) in stuck.iter().enumerate() {
            frictions[k] = found[N + j];
        }
        let rates = (0..modes.len())
            .map(|k| dot(&s.direction(k), &a) - drift(k))
            .collect();
        Some((a, frictions, rates))
    }

    fn step(&self, modes: &[Mode], t: f64, (q, v): &State<N>, h: f64) -> Option<State<N>> {
        // the classical method of fourth order
        let at = |t: f64, state: &State<N>| Some((state.1, self.accelerations(modes, t, state)?.0));
        let moved = |k: &State<N>, c: f64| {
            let mut next = (*q, *v);
            for i in 0..N {
                next.0[i] += c * k.0[i];
                next.1[i] += c * k.1[i];
            }
            next
        };
        let k1 = at(t, &(*q, *v))?;
        let k2 = at(t + 0.5 * h, &moved(&k1, 0.5 * h))?;
        let k3 = at(t + 0.5 * h, &moved(&k2, 0.5 * h))?;
        let k4 = at(t + h, &moved(&k3, h))?;
        let mut next = (*q, *v);
        for i in 0..N {
            next.0[i] += h / 6.0 * (k1.0[i] + 2.0 * (k2.0[i] + k3.0[i]) + k4.0[i]);
            next.1[i] += h / 6.0 * (k1.1[i] + 2.0 * (k2.1[i] + k3.1[i]) + k4.1[i]);
        }
        Some(next)
    }

    /// The distance of each contact from its next event, negative beyond it: the unused part of the limit, or
    /// the slip.
    fn distances(&self, modes: &[Mode], t: f64, state: &State<N>) -> Option<Vec<f64>> {
        let (_, frictions, _) = self.accelerations(modes, t, state)?;
        Some(
            modes
                .iter()
                .enumerate()
                .map(|(k, mode)| match mode {
                    Mode::Sticks => 1.0 - frictions[k].abs() / self.0.limit(k, 0.0),
                    Mode::Slips(side) => side * self.slip(k, t, state),
                })
                .collect(),
        )
    }

    /// The modes in which the motion continues from a state in which some contacts have no slip; `None` if there are several or
    /// none.
    fn decide(&self, modes: &[Mode], open: &[usize], t: f64, state: &State<N>) -> Option<(Vec<Mode>, f64)> {
        let mut found: Vec<(Vec<Mode>, f64)> = Vec::new();
        for code in 0..3_usize.pow(u32::try_from(open.len()).unwrap()) {
            let mut tried = modes.to_vec();
            let mut rest = code;
            for &k in open {
                tried[k] = [Mode::Sticks, Mode::Slips(1.0), Mode::Slips(-1.0)][rest % 3];
                rest /= 3;
            }
            let Some((_, frictions, rates)) = self.accelerations(&tried, t, state) else {
                continue;
            };
            let margins = open.iter().map(|&k| match tried[k] {
                Mode::Sticks => 1.0 - frictions[k].abs() / self.0.limit(k, 0.0),
                Mode::Slips(side) => side * rates[k],
            });
            let margin = margins.fold(f64::INFINITY, f64::min);
            if margin > 0.0 {
                found.push((tried, margin));
            }
        }
        if found.len() == 1 { found.pop() } else { None }
    }

    /// The motion from a time and a state, in which some contacts may stick, to another time.
    pub(super) fn run(
        &self,
        (q, v): State<N>,
        sticks: &[bool],
        [mut t, until]: [f64; 2],
        h: f64,
    ) -> Option<Motion<N>> {
        let count = self.0.contacts();
        let mut state = (q, v);
        let mut modes: Vec<Mode> = (0..count)
            .map(|k| Mode::Slips(self.slip(k, t, &state).signum()))
            .collect();
        let open: Vec<usize> = (0..count).filter(|&k| sticks[k]).collect();
        let mut motion = Motion {
            pieces: Vec::new(),
            events: Vec::new(),
            margin: f64::INFINITY,
            sticks: Vec::new(),
        };
        if !open.is_empty() {
            let margin;
            (modes, margin) = self.decide(&modes, &open, t, &state)?;
            motion.margin = motion.margin.min(margin);
        }
        // a contact that begins to slip at zero is watched once its slip has left zero
        let mut armed: Vec<bool> = modes
            .iter()
            .enumerate()
            .map(|(k, _)| !sticks[k] || modes[k] == Mode::Sticks)
            .collect();
        let mut before = self.distances(&modes, t, &state)?;
        let mut falling = vec![true; count];
        while t < until - 1e-12 {
            let mut dt = h.min(until - t);
            let mut next = self.step(&modes, t, &state, dt)?;
            let mut after = self.distances(&modes, t + dt, &next)?;
            let mut event = None;
            if (0..count).any(|k| armed[k] && after[k] < 0.0) {
                let (mut low, mut high) = (0.0, dt);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    let there = self.step(&modes, t, &state, middle)?;
                    let distances = self.distances(&modes, t + middle, &there)?;
                    if (0..count).any(|k| armed[k] && distances[k] < 0.0) {
                        high = middle;
                    } else {
                        low = middle;
                    }
                }
                dt = high;
                next = self.step(&modes, t, &state, dt)?;
                after = self.distances(&modes, t + dt, &next)?;
                event = (0..count).find(|&k| armed[k] && after[k] < 0.0);
            }
            let piece = Piece {
                t: [t, t + dt],
                q: [state.0, next.0],
                v: [state.1, next.1],
                a: [
                    self.accelerations(&modes, t, &state)?.0,
                    self.accelerations(&modes, t + dt, &next)?.0,
                ],
            };
            motion.pieces.push(piece);
            (t, state) = (t + dt, next);
            for k in 0..count {
                // a minimum of a distance without an event
                let falls = after[k] < before[k];
                if armed[k] && falling[k] && !falls && Some(k) != event {
                    motion.margin = motion.margin.min(before[k].abs());
                }
                falling[k] = falls;
                armed[k] |= after[k] > 1e-7;
            }
            if let Some(k) = event {
                let rate = (before[k] - after[k]) / dt.max(1e-9);
                motion.margin = motion.margin.min(rate);
                if modes[k] == Mode::Sticks {
                    let friction = self.accelerations(&modes, t, &state)?.1[k];
                    modes[k] = Mode::Slips(-friction.signum());
                    armed[k] = false;
                    motion.events.push((t, k, Kind::Release));
                } else {
                    let mut open: Vec<usize> = (0..count).filter(|&j| modes[j] == Mode::Sticks).collect();
                    open.push(k);
                    let old = modes.clone();
                    let margin;
                    (modes, margin) = self.decide(&modes, &open, t, &state)?;
                    motion.margin = motion.margin.min(margin);
                    for &j in &open {
                        let kind = match (old[j], modes[j]) {
                            (Mode::Slips(_), Mode::Sticks) => Kind::Stop,
                            (Mode::Sticks, Mode::Slips(_)) => Kind::Release,
                            (Mode::Slips(_), Mode::Slips(_)) => Kind::Crossing,
                            _ => continue,
                        };
                        armed[j] = modes[j] == Mode::Sticks;
                        motion.events.push((t, j, kind));
                    }
                }
                after = self.distances(&modes, t, &state)?;
                falling = vec![true; count];
            }
            before = after;
        }
        motion.sticks = modes.iter().map(|mode| *mode == Mode::Sticks).collect();
        Some(motion)
    }
}

impl<const N: usize> Motion<N> {
    /// Position and velocity at a time, by a polynomial of degree 5 in each step.
    pub(super) fn at(&self, t: f64) -> State<N> {
        let place = self
            .pieces
            .partition_point(|piece| piece.t[1] < t)
            .min(self.pieces.len() - 1);
        let piece = &self.pieces[place];
        let h = piece.t[1] - piece.t[0];
        let s = (t - piece.t[0]) / h;
        let (mut q, mut v) = ([0.0; N], [0.0; N]);
        for i in 0..N {
            let ([q0, q1], [v0, v1], [a0, a1]) = (
                [piece.q[0][i], piece.q[1][i]],
                [h * piece.v[0][i], h * piece.v[1][i]],
                [h * h * piece.a[0][i], h * h * piece.a[1][i]],
            );
            let (r0, r1, r2) = (q1 - q0 - v0 - 0.5 * a0, v1 - v0 - a0, a1 - a0);
            let (c3, c4, c5) = (
                10.0 * r0 - 4.0 * r1 + 0.5 * r2,
                -15.0 * r0 + 7.0 * r1 - r2,
                6.0 * r0 - 3.0 * r1 + 0.5 * r2,
            );
            q[i] = q0 + s * (v0 + s * (0.5 * a0 + s * (c3 + s * (c4 + s * c5))));
            v[i] = (v0 + s * (a0 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)))) / h;
        }
        (q, v)
    }

    /// Appends another motion.
    pub(super) fn then(mut self, next: Self) -> Self {
        self.pieces.extend(next.pieces);
        self.events.extend(next.events);
        self.margin = self.margin.min(next.margin);
        Self {
            sticks: next.sticks,
            ..self
        }
    }

    /// The least time between two of the events, the `others` and both ends; simultaneous events are one.
    pub(super) fn gap(&self, others: &[f64], until: f64) -> f64 {
        let mut times: Vec<f64> = self.events.iter().map(|event| event.0).collect();
        times.dedup();
        times.extend([0.0, until]);
        times.extend(others);
        times.sort_by(f64::total_cmp);
        times
            .windows(2)
            .map(|pair| pair[1] - pair[0])
            .fold(f64::INFINITY, f64::min)
    }
}
