//! What [`stage!`](crate::stage!) makes of an access word. Where a rule has an arm for any word, that is what `read` means,
//! so that a word which does not exist is one error: that of `__stage_word`.

#[doc(hidden)]
#[macro_export]
macro_rules! __stage_word {
    (uniform) => {};
    (read) => {};
    (write) => {};
    (read_write) => {};
    (atomic) => {};
    (previous) => {};
    (host_only) => {};
    (sampled) => {};
    (stored) => {};
    (acceleration) => {};
    (optional_acceleration) => {};
    (optional_read) => {};
    (optional_write) => {};
    (optional_read_write) => {};
    ($access:ident) => {
        compile_error!(concat!(
            "`",
            stringify!($access),
            "` is no access word; use uniform, read, write, read_write, atomic, previous, host_only, sampled, stored, \
             acceleration, optional_acceleration, optional_read, optional_write or optional_read_write"
        ));
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __stage_input {
    ($g:lifetime previous $ty:ty) => { &$g $crate::Previous<$ty> };
    ($g:lifetime write $ty:ty) => { $crate::Buffer<$ty> };
    ($g:lifetime read_write $ty:ty) => { $crate::Buffer<$ty> };
    ($g:lifetime atomic $ty:ty) => { $crate::Buffer<$ty> };
    ($g:lifetime sampled $ty:ty) => { &$g $crate::Image<$ty> };
    ($g:lifetime stored $ty:ty) => { $crate::Image<$ty> };
    ($g:lifetime acceleration $ty:ty) => { &$g $crate::Acceleration };
    ($g:lifetime optional_acceleration $ty:ty) => { Option<&$g $crate::Acceleration> };
    ($g:lifetime optional_read $ty:ty) => { Option<&$g $crate::Buffer<$ty>> };
    ($g:lifetime optional_write $ty:ty) => { Option<$crate::Buffer<$ty>> };
    ($g:lifetime optional_read_write $ty:ty) => { Option<$crate::Buffer<$ty>> };
    ($g:lifetime $access:ident $ty:ty) => { &$g $crate::Buffer<$ty> };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __stage_view {
    ($a:lifetime uniform $ty:ty) => { &$a $ty };
    ($a:lifetime write $ty:ty) => { $crate::WriteView<$a, $ty> };
    ($a:lifetime read_write $ty:ty) => { $crate::WriteView<$a, $ty> };
    ($a:lifetime atomic $ty:ty) => { $crate::AtomicView<$a> };
    ($a:lifetime sampled $ty:ty) => { $crate::ImageView<$a, $ty> };
    ($a:lifetime stored $ty:ty) => { $crate::ImageStore<$a, $ty> };
    ($a:lifetime optional_write $ty:ty) => { $crate::WriteView<$a, $ty> };
    ($a:lifetime optional_read_write $ty:ty) => { $crate::WriteView<$a, $ty> };
    ($a:lifetime $access:ident $ty:ty) => { $crate::ReadView<$a, $ty> };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __stage_access {
    (uniform) => {
        $crate::Access::Uniform
    };
    (host_only) => {
        $crate::Access::HostOnly
    };
    (previous) => {
        $crate::Access::Previous
    };
    (write) => {
        $crate::Access::Write
    };
    (read_write) => {
        $crate::Access::ReadWrite
    };
    (atomic) => {
        $crate::Access::Atomic
    };
    (sampled) => {
        $crate::Access::Sampled
    };
    (stored) => {
        $crate::Access::Stored
    };
    (acceleration) => {
        $crate::Access::Acceleration
    };
    (optional_acceleration) => {
        $crate::Access::Acceleration
    };
    (optional_write) => {
        $crate::Access::Write
    };
    (optional_read_write) => {
        $crate::Access::ReadWrite
    };
    ($access:ident) => {
        $crate::Access::Read
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __stage_optional {
    (optional_acceleration) => {
        true
    };
    (optional_read) => {
        true
    };
    (optional_write) => {
        true
    };
    (optional_read_write) => {
        true
    };
    ($access:ident) => {
        false
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __stage_element {
    (sampled $ty:ty) => {
        <$ty as $crate::Texel>::FORMAT.value()
    };
    (stored $ty:ty) => {
        <$ty as $crate::Texel>::FORMAT.value()
    };
    ($access:ident $ty:ty) => {
        <$ty as $crate::Element>::layout()
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __stage_image {
    (sampled $ty:ty) => {
        Some(<$ty as $crate::Texel>::FORMAT)
    };
    (stored $ty:ty) => {
        Some(<$ty as $crate::Texel>::FORMAT)
    };
    ($access:ident $ty:ty) => {
        None
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __stage_bind_view {
    (uniform $ty:ty, $next:ident, $group:ident, $port:ident) => {
        &$crate::ReadView::<$ty>::of($crate::next_view(&mut $next, stringify!($port))).slice()[0]
    };
    (write $ty:ty, $next:ident, $group:ident, $port:ident) => {
        $crate::WriteView::of($crate::next_view(&mut $next, stringify!($port)), $group)
    };
    (read_write $ty:ty, $next:ident, $group:ident, $port:ident) => {
        $crate::WriteView::of($crate::next_view(&mut $next, stringify!($port)), $group)
    };
    (optional_write $ty:ty, $next:ident, $group:ident, $port:ident) => {
        $crate::WriteView::of($crate::next_view(&mut $next, stringify!($port)), $group)
    };
    (optional_read_write $ty:ty, $next:ident, $group:ident, $port:ident) => {
        $crate::WriteView::of($crate::next_view(&mut $next, stringify!($port)), $group)
    };
    (atomic $ty:ty, $next:ident, $group:ident, $port:ident) => {
        $crate::AtomicView::of($crate::next_view(&mut $next, stringify!($port)))
    };
    (sampled $ty:ty, $next:ident, $group:ident, $port:ident) => {
        $crate::ImageView::of($crate::next_view(&mut $next, stringify!($port)))
    };
    (stored $ty:ty, $next:ident, $group:ident, $port:ident) => {
        $crate::ImageStore::of($crate::next_view(&mut $next, stringify!($port)), $group)
    };
    ($access:ident $ty:ty, $next:ident, $group:ident, $port:ident) => {
        $crate::ReadView::of($crate::next_view(&mut $next, stringify!($port)))
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __stage_record {
    (acceleration $r:ident, $handle:expr, $port:expr) => {
        $r.acceleration($handle, $port)
    };
    (optional_acceleration $r:ident, $handle:expr, $port:expr) => {
        if let Some(handle) = $handle {
            $r.acceleration(handle, $port)
        }
    };
    (optional_read $r:ident, $handle:expr, $port:expr) => {
        if let Some(handle) = $handle {
            $r.read(handle, $port)
        }
    };
    (optional_write $r:ident, $handle:expr, $port:expr) => {
        $handle.map(|handle| $r.write(handle, $port))
    };
    (optional_read_write $r:ident, $handle:expr, $port:expr) => {
        $handle.map(|handle| $r.read_write(handle, $port))
    };
    (uniform $r:ident, $handle:expr, $port:expr) => {
        $r.uniform($handle, $port)
    };
    (host_only $r:ident, $handle:expr, $port:expr) => {
        $r.host_only($handle, $port)
    };
    (previous $r:ident, $handle:expr, $port:expr) => {
        $r.previous($handle, $port)
    };
    (write $r:ident, $handle:expr, $port:expr) => {
        $r.write($handle, $port)
    };
    (read_write $r:ident, $handle:expr, $port:expr) => {
        $r.read_write($handle, $port)
    };
    (atomic $r:ident, $handle:expr, $port:expr) => {
        $r.atomic($handle, $port)
    };
    (sampled $r:ident, $handle:expr, $port:expr) => {
        $r.sampled($handle, $port)
    };
    (stored $r:ident, $handle:expr, $port:expr) => {
        $r.stored($handle, $port)
    };
    ($access:ident $r:ident, $handle:expr, $port:expr) => {
        $r.read($handle, $port)
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __stage_outputs {
    ($name:ident [$($out:ident $oty:tt,)*] write $port:ident : $ty:ty, $($rest:tt)*) => {
        $crate::__stage_outputs!($name [$($out $oty,)* $port ($crate::Buffer<$ty>),] $($rest)*);
    };
    ($name:ident [$($out:ident $oty:tt,)*] read_write $port:ident : $ty:ty, $($rest:tt)*) => {
        $crate::__stage_outputs!($name [$($out $oty,)* $port ($crate::Buffer<$ty>),] $($rest)*);
    };
    ($name:ident [$($out:ident $oty:tt,)*] optional_write $port:ident : $ty:ty, $($rest:tt)*) => {
        $crate::__stage_outputs!($name [$($out $oty,)* $port (Option<$crate::Buffer<$ty>>),] $($rest)*);
    };
    ($name:ident [$($out:ident $oty:tt,)*] optional_read_write $port:ident : $ty:ty, $($rest:tt)*) => {
        $crate::__stage_outputs!($name [$($out $oty,)* $port (Option<$crate::Buffer<$ty>>),] $($rest)*);
    };
    ($name:ident [$($out:ident $oty:tt,)*] stored $port:ident : $ty:ty, $($rest:tt)*) => {
        $crate::__stage_outputs!($name [$($out $oty,)* $port ($crate::Image<$ty>),] $($rest)*);
    };
    ($name:ident [$($out:ident $oty:tt,)*] atomic $port:ident : $ty:ty, $($rest:tt)*) => {
        $crate::__stage_outputs!($name [$($out $oty,)* $port ($crate::Buffer<$ty>),] $($rest)*);
    };
    ($name:ident [$($out:ident $oty:tt,)*] $access:ident $port:ident : $ty:ty, $($rest:tt)*) => {
        $crate::__stage_outputs!($name [$($out $oty,)*] $($rest)*);
    };
    ($name:ident [$($out:ident $oty:tt,)*]) => {
        #[doc = concat!("Versions that [`", stringify!($name), "`] makes.")]
        #[allow(missing_docs)]
        pub struct Outputs {
            $(pub $out: $oty,)*
        }
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __stage_result {
    ([$($out:ident,)*] write $port:ident, $($rest:tt)*) => { $crate::__stage_result!([$($out,)* $port,] $($rest)*) };
    ([$($out:ident,)*] read_write $port:ident, $($rest:tt)*) => { $crate::__stage_result!([$($out,)* $port,] $($rest)*) };
    ([$($out:ident,)*] optional_write $port:ident, $($rest:tt)*) => { $crate::__stage_result!([$($out,)* $port,] $($rest)*) };
    ([$($out:ident,)*] optional_read_write $port:ident, $($rest:tt)*) => { $crate::__stage_result!([$($out,)* $port,] $($rest)*) };
    ([$($out:ident,)*] atomic $port:ident, $($rest:tt)*) => { $crate::__stage_result!([$($out,)* $port,] $($rest)*) };
    ([$($out:ident,)*] stored $port:ident, $($rest:tt)*) => { $crate::__stage_result!([$($out,)* $port,] $($rest)*) };
    ([$($out:ident,)*] $access:ident $port:ident, $($rest:tt)*) => {{
        let () = $port;
        $crate::__stage_result!([$($out,)*] $($rest)*)
    }};
    ([$($out:ident,)*]) => { Outputs { $($out,)* } };
}
