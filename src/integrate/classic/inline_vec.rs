//! A short list that lives on the stack: what a ray carries must not allocate. Longer lists spill to the heap.

/// A list whose first `N` items stand inline.
#[derive(Clone, Debug)]
pub struct InlineVec<T, const N: usize> {
    len: usize,
    inline: [T; N],
    /// The items behind; boxed, so that copying and dropping a short list asks one pointer.
    #[expect(clippy::box_collection, reason = "a list with its capacity is three words, a pointer one")]
    spill: Option<Box<Vec<T>>>,
}

impl<T: Copy + Default, const N: usize> Default for InlineVec<T, N> {
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

    /// Item `i`, which must exist.
    #[inline]
    pub fn get(&self, i: usize) -> T {
        debug_assert!(i < self.len, "items are asked for below len");
        if i < N { self.inline[i] } else { self.spilled()[i - N] }
    }

    /// The last item.
    #[inline]
    pub fn last(&self) -> Option<T> {
        self.len.checked_sub(1).map(|i| self.get(i))
    }

    /// Appends.
    #[inline]
    pub fn push(&mut self, item: T) {
        if self.len < N {
            self.inline[self.len] = item;
        } else {
            self.spill.get_or_insert_default().push(item);
        }
        self.len += 1;
    }

    /// Takes item `i` out; those behind it move up.
    pub fn remove(&mut self, i: usize) {
        for k in i + 1..self.len {
            let item = self.get(k);
            if k - 1 < N {
                self.inline[k - 1] = item;
            } else if let Some(spill) = &mut self.spill {
                spill[k - 1 - N] = item;
            }
        }
        if let (true, Some(spill)) = (self.len > N, &mut self.spill) {
            spill.pop();
        }
        self.len -= 1;
    }

    /// All items in order.
    pub fn iter(&self) -> impl Iterator<Item = T> + '_ {
        self.inline[..self.len.min(N)].iter().chain(self.spilled()).copied()
    }

    #[inline]
    fn spilled(&self) -> &[T] {
        self.spill.as_ref().map_or(&[], |s| s)
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
        v.remove(0);
        assert_eq!((v.iter().collect::<Vec<_>>(), v.last()), (vec![2, 3], Some(3)));
    }
}
