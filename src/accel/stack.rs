//! A stack in place whose unused part is never written: clearing it would cost more than many a walk.
#![allow(unsafe_code)]

use std::mem::MaybeUninit;

/// Room for a [`Stack`] of at most `N` things.
pub(super) struct Room<T, const N: usize>([MaybeUninit<T>; N]);

impl<T: Copy, const N: usize> Room<T, N> {
    #[inline(always)]
    pub fn new() -> Self {
        Self([const { MaybeUninit::uninit() }; N])
    }

    /// An empty stack in it. Apart from its room, its length stays in a register.
    #[inline(always)]
    pub fn stack(&mut self) -> Stack<'_, T, N> {
        Stack { items: &mut self.0, len: 0 }
    }
}

/// At most `N` things.
pub(super) struct Stack<'r, T, const N: usize> {
    items: &'r mut [MaybeUninit<T>; N],
    /// Everything below was pushed.
    len: usize,
}

impl<'r, T: Copy, const N: usize> Stack<'r, T, N> {
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

    /// All of them, the last pushed last.
    #[inline(always)]
    pub fn into_items(self) -> &'r mut [T] {
        // SAFETY: everything below the length was pushed.
        unsafe { self.items[..self.len].assume_init_mut() }
    }
}
