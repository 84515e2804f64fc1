//! How a step went.

use super::{call, slice_mut};
use crate::{Error, Function, Model};
use fmi2::{
    fmi2Boolean, fmi2Component, fmi2Integer, fmi2LastSuccessfulTime, fmi2Real, fmi2Status,
    fmi2StatusKind, fmi2String, fmi2Terminated,
};

/// `fmi2GetRealStatus`: the last successful time.
///
/// # Safety
/// See the module [`super`].
pub unsafe fn get_real_status<M: Model>(
    c: fmi2Component,
    kind: fmi2StatusKind,
    value: *mut fmi2Real,
) -> fmi2Status {
    // SAFETY: the module's contract.
    unsafe {
        call::<M>(c, |component| {
            let time = component.instance.last_successful_time()?;
            let value = slice_mut(value, 1, "value")?;
            if kind != fmi2LastSuccessfulTime {
                let function = Function::GetRealStatus.name;
                return Err(Error::NoStatus { function, kind });
            }
            value[0] = time;
            Ok(())
        })
    }
}

/// `fmi2GetBooleanStatus`: whether the model came to its end.
///
/// # Safety
/// See the module [`super`].
pub unsafe fn get_boolean_status<M: Model>(
    c: fmi2Component,
    kind: fmi2StatusKind,
    value: *mut fmi2Boolean,
) -> fmi2Status {
    // SAFETY: the module's contract.
    unsafe {
        call::<M>(c, |component| {
            let terminated = component.instance.terminated()?;
            let value = slice_mut(value, 1, "value")?;
            if kind != fmi2Terminated {
                let function = Function::GetBooleanStatus.name;
                return Err(Error::NoStatus { function, kind });
            }
            value[0] = fmi2Boolean::from(terminated);
            Ok(())
        })
    }
}

/// Status functions that ask after a pending step, of which there is none.
macro_rules! no_status {
    ($($name:ident: $type:ty as $function:ident;)*) => {
        $(
            #[doc = concat!("`fmi2", stringify!($function), "`.")]
            ///
            /// # Safety
            /// See the module [`super`].
            pub unsafe fn $name<M: Model>(
                c: fmi2Component,
                kind: fmi2StatusKind,
                _value: *mut $type,
            ) -> fmi2Status {
                // SAFETY: the module's contract.
                unsafe {
                    call::<M>(c, |component| {
                        component.instance.permit(Function::$function)?;
                        let function = Function::$function.name;
                        Err(Error::NoStatus { function, kind })
                    })
                }
            }
        )*
    };
}

no_status! {
    get_status: fmi2Status as GetStatus;
    get_integer_status: fmi2Integer as GetIntegerStatus;
    get_string_status: fmi2String as GetStringStatus;
}

/// `fmi2CancelStep`: never legal, for no step is ever pending.
///
/// # Safety
/// See the module [`super`].
pub unsafe fn cancel_step<M: Model>(c: fmi2Component) -> fmi2Status {
    // SAFETY: the module's contract.
    unsafe {
        call::<M>(c, |component| {
            component.instance.permit(Function::CancelStep)
        })
    }
}
