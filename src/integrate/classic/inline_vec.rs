//! A short list that lives on the stack: what a ray carries must not allocate. Longer lists spill to the heap.

/// A list of up to `N` items inline, of more on the heap.
#[derive(Clone, Debug)]
pub struct InlineVec<T, const N: usize> {
    len: usize,
    inline: [T; N],
    /// All items of a list that is longer; boxed, so that copying and dropping a short list asks one pointer.
    #[expect(clippy::box_collection, reason = "a list with its capacity is three words, a pointer one")]
    spill: Option<Box<Vec<T>>>,
}

impl<T: Copy + Default, const N: usize> Default for InlineVec<T, N> {
    #[inline]
    fn default() -> Self {
        Self { len: 0, inline: [T::default(); N], spill: None }
    }
}

impl<T: Copy + Default, const N: usize> InlineVec<T, N> {
    /// Number of items.
    #[inline]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is nothing in it.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The items, one after another.
    #[inline]
    pub fn as_slice(&self) -> &[T] {
        match &self.spill {
            Some(all) => all,
            None => &self.inline[..self.len.min(N)],
        }
    }

    /// Item `i`, which must exist.
    #[inline]
    pub fn get(&self, i: usize) -> T {
        self.as_slice()[i]
    }

    /// The last item.
    #[inline]
    pub fn last(&self) -> Option<T> {
        self.as_slice().last().copied()
    }

    /// Appends.
    #[inline]
    pub fn push(&mut self, item: T) {
        if self.len < N {
            self.inline[self.len] = item;
        } else {
            self.spill(item);
        }
        self.len += 1;
    }

    #[cold]
    fn spill(&mut self, item: T) {
        self.spill.get_or_insert_with(|| Box::new(self.inline.to_vec())).push(item);
    }

    /// Takes item `i` out; those behind it move up.
    pub fn remove(&mut self, i: usize) {
        self.len -= 1;
        match &mut self.spill {
            None => self.inline.copy_within(i + 1..=self.len, i),
            Some(all) => {
                all.remove(i);
                if all.len() == N {
                    self.inline.copy_from_slice(all);
                    self.spill = None;
                }
            }
        }
    }

    /// All items in order.
    #[inline]
    pub fn iter(&self) -> impl Iterator<Item = T> + '_ {
        self.as_slice().iter().copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_keep_their_order_across_the_spill() {
        let mut v = InlineVec::<u32, 2>::default();
        (0..5).for_each(|k| v.push(k));
        v.remove(1);
        assert_eq!(v.iter().collect::<Vec<_>>(), [0, 2, 3, 4]);
        v.remove(3);
        assert_eq!(v.iter().collect::<Vec<_>>(), [0, 2, 3]);
        v.remove(0);
        assert_eq!((v.iter().collect::<Vec<_>>(), v.last()), (vec![2, 3], Some(3)));
        v.push(7);
        assert_eq!((v.as_slice(), v.len(), v.get(2)), (&[2, 3, 7][..], 3, 7));
    }
}
