//! Functions of FMI 3.0 for what a flight model does not have: variables that are no real numbers, clocks, dependencies, partitions.

macro_rules! unsupported {
    ($($name:ident)*) => {
        $(
            /// Says that there is nothing of the kind; its arguments are not looked at.
            #[unsafe(no_mangle)]
            pub extern "C" fn $name() -> i32 {
                // An error.
                3
            }
        )*
    };
}

unsupported!(fmi3GetFloat32 fmi3GetInt8 fmi3GetUInt8 fmi3GetInt16 fmi3GetUInt16 fmi3GetInt32 fmi3GetUInt32 fmi3GetInt64 fmi3GetUInt64
    fmi3GetBoolean fmi3GetString fmi3GetBinary fmi3GetClock
    fmi3SetFloat32 fmi3SetInt8 fmi3SetUInt8 fmi3SetInt16 fmi3SetUInt16 fmi3SetInt32 fmi3SetUInt32 fmi3SetInt64 fmi3SetUInt64
    fmi3SetBoolean fmi3SetString fmi3SetBinary fmi3SetClock
    fmi3GetNumberOfVariableDependencies fmi3GetVariableDependencies
    fmi3SerializedFMUStateSize fmi3SerializeFMUState fmi3DeserializeFMUState
    fmi3GetDirectionalDerivative fmi3GetAdjointDerivative
    fmi3GetIntervalDecimal fmi3GetIntervalFraction fmi3GetShiftDecimal fmi3GetShiftFraction
    fmi3SetIntervalDecimal fmi3SetIntervalFraction fmi3SetShiftDecimal fmi3SetShiftFraction
    fmi3GetOutputDerivatives fmi3ActivateModelPartition);

/// There is no scheduled execution: gives no instance.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3InstantiateScheduledExecution() -> *mut std::ffi::c_void {
    std::ptr::null_mut()
}
