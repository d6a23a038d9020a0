//! Pairs of terms that always occur together in sums.
//!
//! The acceleration of a link has two terms, `cⱼ aⱼ` and `sⱼ vⱼ²`, with the same ratio of coefficients in every row. Joined, they are one
//! term, which is added at each link of the sum along a chain.

use crate::graph::{Graph, NodeId};
use crate::hash::{HashMap, HashSet};
use crate::passes::running::SplitTerm;

/// The fewest sums in which two terms are joined.
const FEWEST_SUMS: usize = 3;

/// The occurrences of a term: the index of a sum, and the position in it.
type Places = Vec<(usize, usize)>;

/// Joins two terms where one of them occurs only beside the other, and always with the same multiple of its
/// factor. Returns the number of terms in the joined ones.
pub(crate) fn join(graph: &mut Graph, mut sums: Vec<&mut Vec<SplitTerm>>) -> usize {
    let columns = columns(&sums);
    let mut order: Vec<NodeId> = columns.keys().copied().collect();
    order.sort_unstable_by_key(|late| (core::cmp::Reverse(columns[late].len()), *late));
    let (mut hosts, mut guests) = (HashMap::default(), HashSet::default());
    for &guest in &order {
        let places = &columns[&guest];
        if hosts.contains_key(&guest) || places.len() < FEWEST_SUMS {
            continue;
        }
        let first = &*sums[places[0].0];
        let host = first.iter().find_map(|item| {
            let &[(host, 1)] = &item.late[..] else { return None };
            if host == guest || guests.contains(&host) || hosts.contains_key(&host) {
                return None;
            }
            let ratio = ratio(&sums, &columns, host, places)?;
            Some((host, ratio))
        });
        if let Some((host, ratio)) = host {
            hosts.insert(host, (guest, ratio));
            guests.insert(guest);
        }
    }
    let mut made = 0;
    for &host in &order {
        let Some(&(guest, ratio)) = hosts.get(&host) else {
            continue;
        };
        let pair = graph.linear(0.0, &[(host, 1.0), (guest, ratio)]);
        let (size, pair) = graph.split(pair);
        for &(sum, place) in &columns[&guest] {
            let own = sums[sum].iter().position(|item| is(item, host));
            if let Some(own) = own {
                let item = &mut sums[sum][own];
                item.coefficient *= size;
                item.late = vec![(pair, 1)];
                // emptied, not removed, so that positions stay valid until all pairs are joined
                sums[sum][place].late.clear();
            }
        }
        made += 2;
    }
    for sum in sums {
        sum.retain(|item| !item.late.is_empty());
    }
    made
}

/// Whether a term is a multiple of an expression.
fn is(item: &SplitTerm, late: NodeId) -> bool {
    matches!(item.late[..], [(own, 1)] if own == late)
}

/// The occurrences of each term; not of terms that occur twice in a sum.
fn columns(sums: &[&mut Vec<SplitTerm>]) -> HashMap<NodeId, Places> {
    let mut columns: HashMap<NodeId, Places> = HashMap::default();
    let mut twice = HashSet::default();
    for (sum, items) in sums.iter().enumerate() {
        for (place, item) in items.iter().enumerate() {
            let &[(late, 1)] = &item.late[..] else { continue };
            let places = columns.entry(late).or_default();
            if places.last().is_some_and(|&(last, _)| last == sum) {
                twice.insert(late);
            }
            places.push((sum, place));
        }
    }
    columns.retain(|late, _| !twice.contains(late));
    columns
}

/// The ratio of the guest's factor to the host's, if it is the same in all sums with the guest.
fn ratio(
    sums: &[&mut Vec<SplitTerm>],
    columns: &HashMap<NodeId, Places>,
    host: NodeId,
    guests: &Places,
) -> Option<f64> {
    let hosts = columns.get(&host)?;
    let mut of_all = None;
    for &(sum, place) in guests {
        let at = hosts.binary_search_by_key(&sum, |&(sum, _)| sum).ok()?;
        let (host, guest) = (&sums[sum][hosts[at].1], &sums[sum][place]);
        let ratio = guest.coefficient / host.coefficient;
        #[allow(clippy::float_cmp)] // quotients of the same whole numbers
        let same = of_all.is_none_or(|of_all: f64| of_all == ratio);
        if !same || host.early != guest.early {
            return None;
        }
        of_all = Some(ratio);
    }
    of_all
}
