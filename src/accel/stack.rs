//! A stack in place whose unused part is never written: clearing it would cost more than many a walk.
#![allow(unsafe_code)]

use std::mem::MaybeUninit;

/// At most `N` things.
pub(super) struct Stack<T, const N: usize> {
    items: [MaybeUninit<T>; N],
    /// Everything below was pushed.
    len: usize,
}

impl<T: Copy, const N: usize> Stack<T, N> {
    #[inline(always)]
    pub fn new() -> Self {
        Self { items: [const { MaybeUninit::uninit() }; N], len: 0 }
    }

    #[inline(always)]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Panics when it is full.
    #[inline(always)]
    pub fn push(&mut self, item: T) {
        self.items[self.len].write(item);
        self.len += 1;
    }

    #[inline(always)]
    pub fn pop(&mut self) -> Option<T> {
        self.len = self.len.checked_sub(1)?;
        // SAFETY: everything below the former length was pushed.
        Some(unsafe { self.items[self.len].assume_init() })
    }

    /// All of them, the last pushed last.
    #[inline(always)]
    pub fn items(&mut self) -> &mut [T] {
        // SAFETY: everything below the length was pushed.
        unsafe { self.items[..self.len].assume_init_mut() }
    }
}
