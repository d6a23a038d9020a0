//! The share of a sweep that a process computes: given, or from the environment of the scheduler that started
//! it.

use std::fmt;
use std::str::FromStr;

use super::error::SweepError;

/// One of several shares of a sweep. The number of shares has no influence on the results.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Its number, from 0.
    index: u64,
    /// The number of shares.
    count: u64,
    /// The environment variables that it was read from.
    from: Vec<&'static str>,
}

impl Shard {
    /// The whole sweep.
    pub const WHOLE: Self = Self {
        index: 0,
        count: 1,
        from: Vec::new(),
    };

    /// The share `number` of `count`; the first is number 1.
    ///
    /// # Errors
    ///
    /// [`SweepError::Shard`] if `number` is 0 or greater than `count`.
    pub fn new(number: u64, count: u64) -> Result<Self, SweepError> {
        if number == 0 || number > count {
            return Err(SweepError::Shard(format!(
                "there is no shard {number}/{count}: they are 1/{count} to {count}/{count}"
            )));
        }
        Ok(Self {
            index: number - 1,
            count,
            from: Vec::new(),
        })
    }

    /// Whether a part belongs to the shard. Parts are assigned to the shards in turn: neighbouring parts, which often take equally long, go to
    /// different shards.
    #[must_use]
    pub fn has(&self, part: u64) -> bool {
        part % self.count == self.index
    }

    /// The number of shares.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The environment variables that it was read from; empty if it was given.
    #[must_use]
    pub fn origin(&self) -> &[&'static str] {
        &self.from
    }

    /// The share that a scheduler gives by its environment variables; `None` if there is no scheduler. `variable` reads a variable. `count` is the
    /// number of tasks of an array, for schedulers that do not give it to their tasks (PBS, Kubernetes).
    ///
    /// The tasks of an array (SLURM, PBS, LSF, Grid Engine, AWS Batch, Kubernetes) may have several ranks each (`srun`, Open MPI, PMI, AWS
    /// Batch's nodes). Then the number of shares is the number of tasks times the number of ranks.
    ///
    /// # Errors
    ///
    /// [`SweepError::Shard`] if a variable is not a number, or if the number of tasks is not known.
    pub fn of_environment(
        variable: &dyn Fn(&str) -> Option<String>,
        count: Option<u64>,
    ) -> Result<Option<Self>, SweepError> {
        let mut shard = Self::WHOLE;
        for group in [ARRAY_SCHEDULERS, RANK_SCHEDULERS] {
            for scheduler in group {
                if let Some((index, own)) = scheduler.read(variable, count)? {
                    shard = Self {
                        index: shard.index * own + index % own,
                        count: shard.count * own,
                        from: shard.from.into_iter().chain([scheduler.index]).collect(),
                    };
                    break;
                }
            }
        }
        Ok((!shard.from.is_empty()).then_some(shard))
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index + 1, self.count)
    }
}

impl FromStr for Shard {
    type Err = SweepError;

    fn from_str(text: &str) -> Result<Self, SweepError> {
        let numbers = text
            .split_once('/')
            .map(|(number, count)| (number.parse(), count.parse()));
        match numbers {
            Some((Ok(number), Ok(count))) => Self::new(number, count),
            _ => Err(SweepError::Shard(format!(
                "`{text}` is no shard; expected a number of a number, as in 2/8"
            ))),
        }
    }
}

/// The environment variables by which a scheduler numbers its tasks.
struct Scheduler {
    /// The variable of the task's number.
    index: &'static str,
    /// The number of tasks.
    size: Size,
}

/// The environment variables that give the number of tasks.
enum Size {
    /// By a variable.
    Count(&'static str),
    /// By the first number, the last number and the step between two. An empty name stands for 1.
    Range([&'static str; 3]),
    /// Not given.
    Unknown,
}

/// Arrays of tasks.
const ARRAY_SCHEDULERS: &[Scheduler] = &[
    Scheduler {
        index: "SLURM_ARRAY_TASK_ID",
        size: Size::Range([
            "SLURM_ARRAY_TASK_MIN",
            "SLURM_ARRAY_TASK_MAX",
            "SLURM_ARRAY_TASK_STEP",
        ]),
    },
    // PBS Pro and OpenPBS, then Torque
    Scheduler {
        index: "PBS_ARRAY_INDEX",
        size: Size::Unknown,
    },
    Scheduler {
        index: "PBS_ARRAYID",
        size: Size::Unknown,
    },
    Scheduler {
        index: "LSB_JOBINDEX",
        size: Size::Range(["", "LSB_JOBINDEX_END", "LSB_JOBINDEX_STEP"]),
    },
    Scheduler {
        index: "SGE_TASK_ID",
        size: Size::Range(["SGE_TASK_FIRST", "SGE_TASK_LAST", "SGE_TASK_STEPSIZE"]),
    },
    Scheduler {
        index: "AWS_BATCH_JOB_ARRAY_INDEX",
        size: Size::Count("AWS_BATCH_JOB_ARRAY_SIZE"),
    },
    Scheduler {
        index: "JOB_COMPLETION_INDEX",
        size: Size::Unknown,
    },
];

/// Ranks within a task. A batch script of SLURM has a rank, but is not one of several. Only a step of SLURM has the number of ranks.
const RANK_SCHEDULERS: &[Scheduler] = &[
    Scheduler {
        index: "OMPI_COMM_WORLD_RANK",
        size: Size::Count("OMPI_COMM_WORLD_SIZE"),
    },
    Scheduler {
        index: "PMI_RANK",
        size: Size::Count("PMI_SIZE"),
    },
    Scheduler {
        index: "SLURM_PROCID",
        size: Size::Count("SLURM_STEP_NUM_TASKS"),
    },
    Scheduler {
        index: "AWS_BATCH_JOB_NODE_INDEX",
        size: Size::Count("AWS_BATCH_JOB_NUM_NODES"),
    },
];

impl Scheduler {
    /// The number of the task, from 0, and the number of tasks; `None` if this scheduler did not start the
    /// process.
    fn read(
        &self,
        variable: &dyn Fn(&str) -> Option<String>,
        given: Option<u64>,
    ) -> Result<Option<(u64, u64)>, SweepError> {
        let number = |name: &str| -> Result<Option<u64>, SweepError> {
            // a job of LSF and Grid Engine that is not an array has an empty or undefined number
            let Some(text) = variable(name).filter(|text| !text.is_empty() && text != "undefined") else {
                return Ok(None);
            };
            match text.parse() {
                Ok(number) => Ok(Some(number)),
                Err(_) => Err(SweepError::Shard(format!(
                    "the variable {name} is `{text}`, not a number; `--shard i/n` says which parts to compute"
                ))),
            }
        };
        let Some(index) = number(self.index)? else {
            return Ok(None);
        };
        match self.size {
            Size::Count(name) => Ok(match number(name)? {
                Some(count) if count > 0 => Some((index, count)),
                // a rank without a number of ranks is the batch script
                _ if self.index == "SLURM_PROCID" => None,
                _ => given.map(|count| (index, count)),
            }),
            Size::Range([first, last, step]) => {
                if self.index == "LSB_JOBINDEX" && index == 0 {
                    return Ok(None);
                }
                let first = if first.is_empty() {
                    1
                } else {
                    number(first)?.unwrap_or(1)
                };
                let step = number(step)?.unwrap_or(1).max(1);
                match number(last)? {
                    Some(last) if first <= index && index <= last => {
                        Ok(Some(((index - first) / step, (last - first) / step + 1)))
                    }
                    _ => self.counted(index, given),
                }
            }
            Size::Unknown => self.counted(index, given),
        }
    }

    /// The number of the task, for schedulers that do not give the number of tasks.
    fn counted(&self, index: u64, given: Option<u64>) -> Result<Option<(u64, u64)>, SweepError> {
        match given {
            // the remainders differ, whether tasks are numbered from 0 or from 1
            Some(count) if count > 0 => Ok(Some((index % count, count))),
            _ => Err(SweepError::Shard(format!(
                "{} = {index} says which task this is, and nothing says how many there are: give `--shards n`, or `--shard 1/1` for all",
                self.index
            ))),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::*;

    fn read(variables: &[(&str, &str)], count: Option<u64>) -> Result<Option<String>, SweepError> {
        let variables: HashMap<&str, &str> = variables.iter().copied().collect();
        let variable = |name: &str| variables.get(name).map(|&text| text.to_owned());
        Ok(Shard::of_environment(&variable, count)?.map(|shard| shard.to_string()))
    }

    #[test]
    fn every_scheduler_is_understood() {
        let slurm = [
            ("SLURM_ARRAY_TASK_ID", "12"),
            ("SLURM_ARRAY_TASK_MIN", "10"),
            ("SLURM_ARRAY_TASK_MAX", "16"),
            ("SLURM_ARRAY_TASK_STEP", "2"),
            ("SLURM_ARRAY_TASK_COUNT", "4"),
            // variables of the batch script
            ("SLURM_PROCID", "0"),
            ("SLURM_NTASKS", "8"),
        ];
        let ranks = [("SLURM_PROCID", "1"), ("SLURM_STEP_NUM_TASKS", "3")];
        let both: Vec<_> = slurm[..5].iter().chain(&ranks).copied().collect();
        for (variables, count, expected) in [
            (&[][..], None, None),
            (&slurm, None, Some("2/4")),
            (&ranks, None, Some("2/3")),
            (&both, None, Some("5/12")),
            // a task that is started again alone takes all that is missing
            (
                &[
                    ("SLURM_ARRAY_TASK_ID", "2"),
                    ("SLURM_ARRAY_TASK_MIN", "2"),
                    ("SLURM_ARRAY_TASK_MAX", "2"),
                ],
                None,
                Some("1/1"),
            ),
            (&[("PBS_ARRAY_INDEX", "4")], Some(4), Some("1/4")),
            (&[("PBS_ARRAYID", "3")], Some(4), Some("4/4")),
            (
                &[("LSB_JOBINDEX", "3"), ("LSB_JOBINDEX_END", "8")],
                None,
                Some("3/8"),
            ),
            (&[("LSB_JOBINDEX", "0")], None, None),
            (
                &[
                    ("SGE_TASK_ID", "5"),
                    ("SGE_TASK_FIRST", "1"),
                    ("SGE_TASK_LAST", "9"),
                    ("SGE_TASK_STEPSIZE", "2"),
                ],
                None,
                Some("3/5"),
            ),
            (&[("SGE_TASK_ID", "undefined")], None, None),
            (
                &[
                    ("AWS_BATCH_JOB_ARRAY_INDEX", "0"),
                    ("AWS_BATCH_JOB_ARRAY_SIZE", "100"),
                ],
                None,
                Some("1/100"),
            ),
            (
                &[
                    ("AWS_BATCH_JOB_NODE_INDEX", "1"),
                    ("AWS_BATCH_JOB_NUM_NODES", "2"),
                ],
                None,
                Some("2/2"),
            ),
            (&[("JOB_COMPLETION_INDEX", "7")], Some(8), Some("8/8")),
            (
                &[
                    ("OMPI_COMM_WORLD_RANK", "2"),
                    ("OMPI_COMM_WORLD_SIZE", "4"),
                    ("PMI_RANK", "9"),
                ],
                None,
                Some("3/4"),
            ),
            (&[("PMI_RANK", "0"), ("PMI_SIZE", "2")], None, Some("1/2")),
        ] {
            assert_eq!(
                read(variables, count).unwrap().as_deref(),
                expected,
                "{variables:?}"
            );
        }
    }

    #[test]
    fn what_a_scheduler_does_not_tell_is_asked_for() {
        for (variables, expected) in [
            (&[("JOB_COMPLETION_INDEX", "7")], "give `--shards n`"),
            (&[("PMI_RANK", "x")], "PMI_RANK is `x`"),
        ] {
            let error = read(variables, None).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
        for text in ["0/4", "5/4", "2", "a/b"] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
    }

    #[test]
    fn shards_share_out_all_parts() {
        for count in 1..8 {
            let shards: Vec<Shard> = (1..=count)
                .map(|number| Shard::new(number, count).unwrap())
                .collect();
            for part in 0..50 {
                assert_eq!(shards.iter().filter(|shard| shard.has(part)).count(), 1);
            }
        }
    }
}
