//! Tests without a device.
