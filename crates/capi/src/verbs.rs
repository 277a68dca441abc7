//! The tables of the interface: types with the sources of their fields, and what a function of C is
//! around its body, one macro a verb.
//!
//! `tools/c_header` reads the expanded source, so docs here are docs of the header. A new question
//! needs its structs and a [`question!`] in one file.

/// Types of the header: each field with its doc, and with its default or where it comes from.
///
/// - `enum`: its numbers are those of the header; `from` an enum of the library with the same
///   names, or from an answer that is `bool` once it is known.
/// - `asked`, `told`: begin with their size and may grow; every caller has the fields up to the one
///   in parentheses. The first is read and has defaults, the second is written.
/// - `row`: may grow, with its size beside an array.
/// - `plain`: stays as it is.
///
/// `from (found: T)` makes one of what the library answers.
macro_rules! types {
    () => {};
    ($(#[$doc:meta])* enum $name:ident $(from $same:ident)? { $($variants:tt)* } $($rest:tt)*) => {
        $(#[$doc])*
        #[repr(u32)]
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $name { $($variants)* }
        $crate::verbs::types! { @same $name [$($same)?] { $($variants)* } }
        $crate::verbs::types! { $($rest)* }
    };
    (@same $name:ident [] $variants:tt) => {};
    (@same $name:ident [bool] $variants:tt) => {
        impl From<Option<bool>> for $name {
            fn from(answer: Option<bool>) -> Self {
                answer.map_or(Self::Undecided, |yes| if yes { Self::Yes } else { Self::No })
            }
        }
    };
    (
        @same $name:ident [$same:ident]
        { $($(#[$about:meta])* $variant:ident = $number:literal),* $(,)? }
    ) => {
        impl From<$same> for $name {
            fn from(same: $same) -> Self {
                match same {
                    $($same::$variant => Self::$variant,)*
                }
            }
        }
    };
    (
        $(#[$doc:meta])* asked $name:ident $(<$life:lifetime>)? ($needed:ident) $(from $found:tt)?
        { $($(#[$about:meta])* $field:ident: $type:ty $(= $value:expr)?),* $(,)? } $($rest:tt)*
    ) => {
        $(#[$doc])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug)]
        pub struct $name $(<$life>)? {
            /// Its size in bytes, as made.
            pub size: u32,
            $($(#[$about])* pub $field: $type,)*
        }
        $crate::sized::grows!($name $(<$life>)?: size, $needed.. $($field)*);
        $crate::verbs::types! {
            @made asked [$(from $found)?] $name $(<$life>)?
            { size: Self::SIZE, $($field $(: $value)?,)* }
        }
        $crate::verbs::types! { $($rest)* }
    };
    (
        $(#[$doc:meta])* told $name:ident ($needed:ident) $(from $found:tt)?
        { $($(#[$about:meta])* $field:ident: $type:ty $(= $value:expr)?),* $(,)? } $($rest:tt)*
    ) => {
        $(#[$doc])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name {
            /// Its size in bytes, to be set before the call.
            pub size: u32,
            $($(#[$about])* pub $field: $type,)*
        }
        $crate::sized::grows!($name: size, $needed.. $($field)*);
        $crate::verbs::types! {
            @made told [$(from $found)?] $name { size: Self::SIZE, $($field $(: $value)?,)* }
        }
        $crate::verbs::types! { $($rest)* }
    };
    (
        $(#[$doc:meta])* row $name:ident ($needed:ident) $(from $found:tt)? { $($fields:tt)* }
        $($rest:tt)*
    ) => {
        $crate::verbs::types! { $(#[$doc])* plain $name $(from $found)? { $($fields)* } }
        $crate::verbs::types! { @grows $name $needed { $($fields)* } }
        $crate::verbs::types! { $($rest)* }
    };
    (
        $(#[$doc:meta])* plain $name:ident $(from $found:tt)?
        { $($(#[$about:meta])* $field:ident: $type:ty $(= $value:expr)?),* $(,)? } $($rest:tt)*
    ) => {
        $(#[$doc])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name {
            $($(#[$about])* pub $field: $type,)*
        }
        $crate::verbs::types! { @made plain [$(from $found)?] $name { $($field $(: $value)?,)* } }
        $crate::verbs::types! { $($rest)* }
    };
    (
        @grows $name:ident $needed:ident
        { $($(#[$about:meta])* $field:ident: $type:ty $(= $value:expr)?),* $(,)? }
    ) => {
        $crate::sized::grows!($name: $needed.. $($field)*);
    };
    (@made asked [] $name:ident $(<$life:lifetime>)? { $($fields:tt)* }) => {
        impl $(<$life>)? Default for $name $(<$life>)? {
            fn default() -> Self {
                Self { $($fields)* }
            }
        }
    };
    (@made $kind:ident [] $($rest:tt)*) => {};
    (
        @made $kind:ident [from ($found:tt: $from:ty)] $name:ident $(<$life:lifetime>)?
        { $($fields:tt)* }
    ) => {
        impl $(<$life>)? From<$from> for $name $(<$life>)? {
            fn from($found: $from) -> Self {
                Self { $($fields)* }
            }
        }
    };
}

/// Opaque handles, and the functions that free them.
macro_rules! handles {
    ($($(#[$doc:meta])* $name:ident($value:ty $(, $more:ty)*);
       $(#[$free_doc:meta])* $free:ident($on:ident);)*) => {$(
        $(#[$doc])*
        #[derive(Debug)]
        pub struct $name(pub(crate) $crate::handle::Handle<$value> $(, pub(crate) $more)*);

        impl $crate::handle::Holds for $name {
            type Value = $value;
            fn handle(&self) -> &$crate::handle::Handle<$value> {
                &self.0
            }
            fn handle_mut(&mut self) -> &mut $crate::handle::Handle<$value> {
                &mut self.0
            }
        }

        impl From<$value> for $name {
            fn from(value: $value) -> Self {
                Self($crate::handle::Handle::new(value) $(, <$more>::default())*)
            }
        }

        $(#[$free_doc])*
        #[unsafe(no_mangle)]
        pub extern "C" fn $free($on: Option<Box<$name>>) {
            $crate::status::free($on);
        }
    )*};
}

/// Functions that return a status: exported under their names, behind
/// [`door`](crate::status::door). `change` changes what a handle holds; `make` hands out a handle.
macro_rules! calls {
    () => {};
    ($(#[$doc:meta])* unsafe fn $name:ident $arguments:tt $body:block $($rest:tt)*) => {
        $crate::verbs::calls! { @ [unsafe] $(#[$doc])* $name $arguments $body }
        $crate::verbs::calls! { $($rest)* }
    };
    ($(#[$doc:meta])* fn $name:ident $arguments:tt $body:block $($rest:tt)*) => {
        $crate::verbs::calls! { @ [] $(#[$doc])* $name $arguments $body }
        $crate::verbs::calls! { $($rest)* }
    };
    (
        $(#[$doc:meta])* change $name:ident($on:ident: $handle:ty $(, $arg:ident: $type:ty)*)
        = $change:expr; $($rest:tt)*
    ) => {
        $crate::verbs::calls! {
            @ [] $(#[$doc])* $name($on: Option<&mut $handle> $(, $arg: $type)*) {
                $crate::handle::change($on, stringify!($on), |$on| {
                    $change;
                    Ok(())
                })
            }
        }
        $crate::verbs::calls! { $($rest)* }
    };
    ($(#[$doc:meta])* unsafe make $($rest:tt)*) => {
        $crate::verbs::calls! { @make [unsafe] [$(#[$doc])*] $($rest)* }
    };
    ($(#[$doc:meta])* make $($rest:tt)*) => {
        $crate::verbs::calls! { @make [] [$(#[$doc])*] $($rest)* }
    };
    (
        @make $unsafe:tt [$(#[$doc:meta])*] $name:ident($($arg:ident: $type:ty),*)
        -> $out:ident: $handle:ty = $made:expr; $($rest:tt)*
    ) => {
        $crate::verbs::calls! {
            @ $unsafe $(#[$doc])* $name(
                $($arg: $type,)* $out: Option<&mut core::mem::MaybeUninit<Option<Box<$handle>>>>
            ) { $crate::handle::put($out, || Ok($made)) }
        }
        $crate::verbs::calls! { $($rest)* }
    };
    (
        @ [$($unsafe:tt)?] $(#[$doc:meta])* $name:ident($($arg:ident: $type:ty),* $(,)?) $body:block
    ) => {
        $(#[$doc])*
        #[unsafe(no_mangle)]
        pub $($unsafe)? extern "C" fn $name($($arg: $type),*) -> $crate::status::punctual_status {
            $crate::status::door(stringify!($name), || $body)
        }
    };
}

/// Functions that make a struct of the size that the caller knows, and set some of its fields.
macro_rules! inits {
    ($($(#[$doc:meta])* $name:ident(
        $place:ident: $made:ident $(<$life:lifetime>)? $(, $arg:ident: $type:ty)*
    ) { $($field:ident $(: $value:expr)?),* })*) => {$(
        $(#[$doc])*
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name$(<$life>)?(
            $place: *mut $made$(<$life>)?, size: usize $(, $arg: $type)*
        ) {
            #[allow(clippy::needless_update, reason = "some structs have no other field")]
            let made = <$made>::default();
            // SAFETY: the contract of the header for structs.
            unsafe { $crate::sized::begin($place, size, $made { $($field $(: $value)?,)* ..made }) }
        }
    )*};
}

/// Functions that write a list: of structs that may grow (`rows`), or of what stays as it is
/// (`list`).
macro_rules! lists {
    () => {};
    ($(#[$doc:meta])* list $name:ident($from:ident: $handle:ty)
        -> $out:ident: $item:ty = $found:expr; $($rest:tt)*) => {
        $crate::verbs::calls! {
            $(#[$doc])*
            #[doc = concat!(" As many as `capacity` allows are written to `", stringify!($out), "`,")]
            /// and how many there are to `count`.
            unsafe fn $name(
                $from: Option<&$handle>, $out: *mut $item, capacity: usize,
                count: Option<&mut core::mem::MaybeUninit<usize>>
            ) {
                let $from = $crate::handle::get($from, stringify!($from))?;
                let count = $crate::status::given(count, "count")?;
                // SAFETY: the contract of the header for arrays.
                unsafe { $crate::arrays::list($out, capacity, stringify!($out), count, $found) }
            }
        }
        $crate::verbs::lists! { $($rest)* }
    };
    ($(#[$doc:meta])* rows $name:ident($from:ident: $handle:ty)
        -> $out:ident: $item:ty, $size:ident = $found:expr; $($rest:tt)*) => {
        $crate::verbs::calls! {
            $(#[$doc])*
            #[doc = concat!(" As many as `capacity` allows are written to `", stringify!($out), "`,")]
            /// and how many there are to `count`.
            unsafe fn $name(
                $from: Option<&$handle>, $out: *mut $item, $size: usize, capacity: usize,
                count: Option<&mut core::mem::MaybeUninit<usize>>
            ) {
                let $from = $crate::handle::get($from, stringify!($from))?;
                let count = $crate::status::given(count, "count")?;
                // SAFETY: the contract of the header for arrays.
                unsafe {
                    $crate::sized::rows($out, $size, capacity, stringify!($out), count, $found)
                }
            }
        }
        $crate::verbs::lists! { $($rest)* }
    };
}

/// The functions of a question: `query(workspace[, memory]) -> answer { verb name; ... }`.
macro_rules! question {
    ($query:ident $state:tt -> $answer:ty { $($(#[$doc:meta])* $verb:ident $name:ident;)* }) => {
        $($crate::verbs::$verb! { $query $state -> $answer; $(#[$doc])* $name })*
    };
}

macro_rules! run {
    (
        $query:ident($workspace:ty $(, $memory:ident)?) -> $answer:ty; $(#[$doc:meta])* $name:ident
    ) => {
        $crate::verbs::spend! {
            $query($workspace $(, $memory)?) -> $answer;
            $(#[$doc])*
            /// `clock` may be null: the clock of the system.
            ///
            /// Fails with NULL, BAD_POSE, BAD_ARGUMENT or POISONED before it has begun; the
            /// workspace is unchanged then.
            $name, query, workspace, budget, query.run(workspace, budget)
        }
    };
}

macro_rules! resume {
    (
        $query:ident($workspace:ty $(, $memory:ident)?) -> $answer:ty; $(#[$doc:meta])* $name:ident
    ) => {
        $crate::verbs::spend! {
            $query($workspace $(, $memory)?) -> $answer;
            /// Goes on with the stopped run that the workspace holds, with a fresh budget.
            $(#[$doc])*
            ///
            /// Fails as a run, and with NOT_RESUMABLE if the last run in this workspace was not of
            /// this very query or is complete.
            $name, query, workspace, budget, query.resume(workspace, budget)?
        }
    };
}

/// What [`run!`] and [`resume!`] have in common.
macro_rules! spend {
    ($query:ident($workspace:ty $(, $memory:ident)?) -> $answer:ty; $(#[$doc:meta])* $name:ident,
        $asked:ident, $held:ident, $budget:ident, $spent:expr) => {
        $crate::verbs::calls! {
            $(#[$doc])*
            unsafe fn $name(
                query: *const $query<'_>, workspace: Option<&mut $workspace>,
                $($memory: Option<&mut $crate::memory::punctual_memory>,)?
                budget: $crate::budget::punctual_budget,
                clock: Option<&$crate::budget::punctual_clock>, outcome: *mut $answer
            ) {
                // SAFETY: the contract of the header for structs and clocks.
                unsafe {
                    let $asked = $crate::sized::read(query, "query")?.check()?;
                    let memory = None $(.or($memory))?;
                    $crate::query::answer(
                        workspace, memory, budget, clock, outcome, |$held, _known, $budget| {
                            $(let $memory = _known; let $asked = $asked.with_memory($memory);)?
                            Ok($spent)
                        },
                    )
                }
            }
        }
    };
}

macro_rules! predict {
    ($query:ident($workspace:ty, $memory:ident) -> $answer:ty; $(#[$doc:meta])* $name:ident) => {
        $crate::verbs::calls! {
            /// Units of work that this query will take if nothing stops it, given what is
            /// remembered of the pair; `memory` may be null. Takes constant time and allocates
            /// nothing.
            $(#[$doc])*
            unsafe fn $name(
                query: *const $query<'_>, $memory: Option<&$crate::memory::punctual_memory>,
                work: Option<&mut core::mem::MaybeUninit<$crate::outcome::punctual_quantiles>>
            ) {
                // SAFETY: the contract of the header for structs.
                let query = unsafe { $crate::sized::read(query, "query") }?.check()?;
                let known = $crate::memory::known($memory)?;
                $crate::status::given(work, "work")?.write(query.predict(known).into());
                Ok(())
            }
        }
    };
}

macro_rules! remaining {
    (
        $query:ident($workspace:ty $(, $memory:ident)?) -> $answer:ty; $(#[$doc:meta])* $name:ident
    ) => {
        $crate::verbs::calls! {
            $(#[$doc])*
            /// What the last run of this query in the workspace has still to do. docs/c.md states
            /// the cost. Allocates nothing.
            $(
                #[doc = concat!("It goes by what is remembered of the pair; `", stringify!($memory), "` may be")]
                /// null, and learns from it when the query has ended.
            )?
            ///
            /// Fails with NOT_RESUMABLE if the last run in this workspace was not of this very
            /// query.
            unsafe fn $name(
                query: *const $query<'_>, workspace: Option<&$workspace>,
                $($memory: Option<&$crate::memory::punctual_memory>,)?
                remaining: *mut $crate::estimate::punctual_remaining
            ) {
                let memory = None $(.or($memory))?;
                // SAFETY: the contract of the header for structs.
                unsafe {
                    let query = $crate::sized::read(query, "query")?.check()?;
                    $crate::estimate::tell(&query, workspace, memory, remaining)
                }
            }
        }
    };
}

macro_rules! certificate {
    (
        $query:ident($workspace:ty $(, $memory:ident)?) -> $answer:ty; $(#[$doc:meta])* $name:ident
    ) => {
        $crate::verbs::calls! {
            $(#[$doc])*
            /// Takes time linear in the open pairs; allocates nothing.
            ///
            /// Fails with NOT_RESUMABLE if the last run in this workspace was not of this very
            /// query.
            unsafe fn $name(
                query: *const $query<'_>, workspace: Option<&$workspace>,
                certificate: *mut $crate::outcome::punctual_certificate
            ) {
                // SAFETY: the contract of the header for structs.
                let (query, certificate) = unsafe {
                    let query = $crate::sized::read(query, "query")?.check()?;
                    (query, $crate::sized::place(certificate, "certificate")?)
                };
                let workspace = $crate::handle::get(workspace, "workspace")?;
                certificate.write(query.certificate(workspace)?.into());
                Ok(())
            }
        }
    };
}

macro_rules! open_boxes {
    (
        $query:ident($workspace:ty $(, $memory:ident)?) -> $answer:ty; $(#[$doc:meta])* $name:ident
    ) => {
        $crate::verbs::calls! {
            /// Boxes in A's frame, at most one for each open pair.
            $(#[$doc])*
            /// As many as `capacity` allows are written to `boxes`, and how many there are to
            /// `count`.
            ///
            /// Fails as the function for the certificate.
            unsafe fn $name(
                query: *const $query<'_>, workspace: Option<&$workspace>,
                boxes: *mut $crate::pose::punctual_aabb, capacity: usize,
                count: Option<&mut core::mem::MaybeUninit<usize>>
            ) {
                // SAFETY: the contract of the header for structs.
                let query = unsafe { $crate::sized::read(query, "query") }?.check()?;
                let count = $crate::status::given(count, "count")?;
                let open = query.certificate($crate::handle::get(workspace, "workspace")?)?;
                // SAFETY: the contract of the header for arrays.
                unsafe { $crate::arrays::list(boxes, capacity, "boxes", count, open.boxes()) }
            }
        }
    };
}

pub(crate) use {
    calls, certificate, handles, inits, lists, open_boxes, predict, question, remaining, resume,
    run, spend, types,
};
