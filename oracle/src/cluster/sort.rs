//! Sorting by keys, those of equal keys in their order.

/// The numbers of the keys, in the order of the keys.
#[must_use]
pub fn order(keys: &[u32]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..keys.len()).collect();
    order.sort_by_key(|&index| (keys[index], index));
    order
}

/// Where the first of each of `count` keys lies among the sorted ones, and behind the last one their number.
#[must_use]
pub fn starts(keys: &[u32], count: usize) -> Vec<usize> {
    let mut starts = vec![0; count + 1];
    for (key, start) in starts.iter_mut().enumerate() {
        *start = keys.iter().filter(|&&other| (other as usize) < key).count();
    }
    starts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_keys_keep_their_order() {
        let keys = [3, 0, 3, 1, 0];
        assert_eq!(order(&keys), [1, 4, 3, 0, 2]);
        // Key 2 begins where it ends.
        assert_eq!(starts(&keys, 5), [0, 2, 3, 3, 5, 5]);
    }
}
