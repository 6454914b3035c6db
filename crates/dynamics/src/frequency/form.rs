//! Forms of low-order equivalent systems.

use std::fmt;

use super::FrequencyError;

/// Highest order of numerator and denominator.
const MOST: usize = 6;

/// What a low-order equivalent system is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// `q/eta = K (s + 1/T_theta2) e^(-tau s) / (s^2 + 2 zeta omega s + omega^2)` (MIL-STD-1797A).
    ShortPeriod,
    /// `p/xi = K e^(-tau s) / (s + 1/T_R)`.
    Roll,
    /// `r/zeta = K (s + 1/T) e^(-tau s) / (s^2 + 2 zeta omega s + omega^2)`.
    Yaw,
    /// `K N(s) e^(-tau s) / D(s)`, monic polynomials of these orders.
    Orders {
        /// Order of the numerator.
        numerator: usize,
        /// Order of the denominator.
        denominator: usize,
    },
}

impl Form {
    /// The form written as its name or as `numerator/denominator` order.
    ///
    /// # Errors
    /// A name that is none, a numerator above its denominator, orders above six.
    pub fn parse(text: &str) -> Result<Self, FrequencyError> {
        let fault = || FrequencyError::Form { text: text.to_owned() };
        match text.trim() {
            "short-period" => return Ok(Self::ShortPeriod),
            "roll" => return Ok(Self::Roll),
            "yaw" => return Ok(Self::Yaw),
            _ => {}
        }
        let (numerator, denominator) = text.split_once('/').ok_or_else(fault)?;
        let order = |text: &str| text.trim().parse::<usize>().map_err(|_| fault());
        let (numerator, denominator) = (order(numerator)?, order(denominator)?);
        let is_form = numerator <= denominator && (1..=MOST).contains(&denominator);
        if is_form { Ok(Self::Orders { numerator, denominator }) } else { Err(fault()) }
    }

    /// Orders of numerator and denominator.
    pub fn orders(self) -> (usize, usize) {
        match self {
            Self::ShortPeriod | Self::Yaw => (1, 2),
            Self::Roll => (0, 1),
            Self::Orders { numerator, denominator } => (numerator, denominator),
        }
    }

    /// Name of the parameter of the only first-order factor of the numerator or the denominator, by the literature of the form.
    pub(super) fn first_order_name(self, is_numerator: bool, number: usize) -> String {
        match (self, is_numerator) {
            (Self::ShortPeriod, true) => "inv_Ttheta2".to_owned(),
            (Self::Yaw, true) => "inv_T".to_owned(),
            (Self::Roll, false) => "inv_TR".to_owned(),
            (_, true) => format!("inv_Tz{number}"),
            (_, false) => format!("inv_Tp{number}"),
        }
    }

    /// What stands behind the names of a second-order factor's parameters.
    pub(super) fn second_order_suffix(self, is_numerator: bool, number: usize) -> String {
        match (is_numerator, number) {
            (true, number) => format!("_z{number}"),
            (false, 1) => String::new(),
            (false, number) => format!("_{number}"),
        }
    }
}

impl fmt::Display for Form {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ShortPeriod => formatter.write_str("short-period"),
            Self::Roll => formatter.write_str("roll"),
            Self::Yaw => formatter.write_str("yaw"),
            Self::Orders { numerator, denominator } => write!(formatter, "{numerator}/{denominator}"),
        }
    }
}
