//! The greedy choice of sets that cover all that they can.

use std::collections::BinaryHeap;

/// The indices of sets whose union is that of all, chosen by the number of elements that no set before has, without
/// those that the others made superfluous. Elements are smaller than `count`. Cost about that of reading all sets some
/// times.
pub(super) fn fewest(sets: &[Vec<usize>], count: usize) -> Vec<usize> {
    let mut times = vec![0_u32; count];
    // The first of equals.
    let heap = sets.iter().enumerate().map(|(i, set)| (set.len(), usize::MAX - i));
    let mut heap: BinaryHeap<_> = heap.collect();
    let mut chosen = Vec::new();
    while let Some((gain, key)) = heap.pop() {
        let set = &sets[usize::MAX - key];
        // The gain only falls, so one that is still the largest is the largest of all.
        let left = set.iter().filter(|i| times[**i] == 0).count();
        if left == 0 {
            continue;
        }
        if left < gain && heap.peek().is_some_and(|next| (left, key) < *next) {
            heap.push((left, key));
            continue;
        }
        chosen.push(usize::MAX - key);
        for i in set {
            times[*i] += 1;
        }
    }
    let mut needed = chosen.clone();
    for i in chosen {
        if sets[i].iter().all(|i| times[*i] > 1) {
            needed.retain(|kept| *kept != i);
            for i in &sets[i] {
                times[*i] -= 1;
            }
        }
    }
    needed
}
