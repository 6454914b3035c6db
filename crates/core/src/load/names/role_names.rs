//! Names that recorders give the channels of each role; German and French words are in `foreign_names.rs`.

use crate::quantity::Role;

/// Names of a role, best first.
pub(crate) type RoleNames = (Role, &'static [&'static str]);

/// Names a role goes by, in small letters without separators, best first.
#[rustfmt::skip]
pub(crate) const NAMES: &[RoleNames] = &[
    (Role::SpecificForceX, &[
        "ax", "accx", "accelx", "xacc", "xaccel", "longacc", "blongacc", "imuax", "nx", "fx", "linearaccelerationx",
        "longitudinalacceleration", "longaccel", "longitudinalaccel", "longac", "lonac", "axialaccel", "accellong",
        "acclong", "accelerationlongitudinal", "xaxisacceleration", "xbodyaxisacceleration", "bodyaccelx", "apilotx",
        "gloadaxial", "accelerationx", "bodyaccelerationx", "inlineacc", "longitudinalacc", "longg", "longitudinalg", "forwardg", "fwdg", "forwardaccel", "fwdaccel", "accelfwd", "accelforward",
        "long", "nxcg", "axcg", "axb", "bx", "gx",
    ]),
    (Role::SpecificForceY, &[
        "ay", "accy", "accely", "yacc", "yaccel", "latacc", "blatacc", "imuay", "ny", "fy", "linearaccelerationy",
        "lateralacceleration", "lataccel", "lateralaccel", "latac", "accellat", "acclat", "accelerationlateral",
        "yaxisacceleration", "ybodyaxisacceleration", "bodyaccely", "apiloty", "accelerationy", "bodyaccelerationy", "lateralacc", "latg",
        "lateralg", "gloadside", "sideg", "nycg", "aycg", "ayb", "by", "gy",
    ]),
    (Role::SpecificForceZ, &[
        "az", "accz", "accelz", "zacc", "zaccel", "normacc", "bnormacc", "imuaz", "nz", "fz", "linearaccelerationz",
        "normalacceleration", "normaccel", "normalaccel", "normac", "vertac", "vertaccel", "vertacc", "verticalaccel",
        "verticalacceleration", "accelvert", "accvert", "accelnorm", "accelerationnormal", "accelerationvertical",
        "zaxisacceleration", "zbodyaxisacceleration", "bodyaccelz", "bodyaccelerationz", "verticalacc", "vrtg", "apilotz", "gforce", "gload", "loadfactor", "load", "nzg",
        "accelerationz", "normalacc", "normalg", "verticalg", "vertg", "loadg", "gloadnormal", "gnormal", "nz1", "nzminus1", "deltanz", "nzcg", "azcg", "azb", "bz", "gz", "an", "g",
    ]),
    (Role::RollRate, &[
        "p", "rollrate", "brollrate", "gyrox", "gyrx", "omegax", "wx", "pbody", "xrate", "angularvelocityx", "rollspeed",
        "rateroll", "ratex", "angularratex", "xgyro", "bodyrollrate", "prate", "rollvel", "velroll", "rollangularrate", "gx", "pb",
    ]),
    (Role::PitchRate, &[
        "q", "pitchrate", "bpitchrate", "gyroy", "gyry", "omegay", "wy", "qbody", "yrate", "angularvelocityy", "pitchspeed",
        "ratepitch", "ratey", "angularratey", "ygyro", "bodypitchrate", "qrate", "pitchvel", "velpitch", "pitchangularrate", "gy", "qb", "ptchrate",
    ]),
    (Role::YawRate, &[
        "r", "yawrate", "byawrate", "gyroz", "gyrz", "omegaz", "wz", "rbody", "zrate", "angularvelocityz", "yawspeed",
        "rateyaw", "ratez", "angularratez", "zgyro", "bodyyawrate", "rrate", "yawvel", "velyaw", "yawangularrate", "gz", "rb",
    ]),
    (Role::RollAcceleration, &["pdot"]),
    (Role::PitchAcceleration, &["qdot"]),
    (Role::YawAcceleration, &["rdot"]),
    (Role::PositionNorth, &["x", "posn", "posnorth", "north", "xe", "xn", "pn", "xpos", "positionnorth", "rn", "xned", "nedn", "n"]),
    (Role::PositionEast, &["y", "pose", "poseast", "east", "ye", "pe", "ypos", "positioneast", "re", "yned", "nede", "e"]),
    (Role::PositionDown, &[
        "z", "posd", "posdown", "down", "ze", "pd", "zpos", "positiondown", "rd", "zned", "nedd", "d", "posup", "positionup", "zup",
    ]),
    (Role::VelocityNorth, &[
        "vnorth", "vn", "veln", "velnorth", "velocitynorth", "speednorth", "gpsvn", "vngps", "northvelocity", "northspeed",
        "nvel", "ndot", "xdot", "northvel", "nsvelocity", "nsvel", "northsouthvelocity",
    ]),
    (Role::VelocityEast, &[
        "veast", "ve", "vele", "veleast", "velocityeast", "speedeast", "gpsve", "vegps", "eastvelocity", "eastspeed",
        "evel", "edot", "ydot", "eastvel", "ewvelocity", "ewvel", "eastwestvelocity",
    ]),
    (Role::VelocityDown, &[
        "vdown", "vd", "veld", "dvel", "downvel", "veldown", "velocitydown", "speeddown", "gpsvd", "vdgps", "downvelocity", "velup", "velu",
        "vup", "velocityup", "upvelocity", "speedup", "climb", "climbspeed", "verticalvelocity", "vertspeed", "vertvel",
        "vertspd", "vspeed", "verticalspd", "vsi", "altdot", "rateofclimbordescent", "vertrate", "inertialverticalspeed", "inertialvertspeed",
        "climbrate", "verticalspeed", "vspd", "rateofclimb", "vs", "vvi", "ivv", "roc", "hdot", "altituderate", "altrate", "vu",
    ]),
    (Role::BankAngle, &[
        "phi", "roll", "bank", "rollangle", "bankangle", "rollattitude", "attituderoll", "bankattitude", "eulerroll",
        "rolleuler", "eulerrollangle", "phib", "ahrsroll", "rollatt", "anglex", "angleroll", "rollang", "angroll",
    ]),
    (Role::PitchAngle, &[
        "theta", "pitch", "tht", "teta", "pitchangle", "the", "ptch", "pitchattitude", "attitudepitch", "eulerpitch", "pitcheuler",
        "eulerpitchangle", "thetab", "ahrspitch", "pitchatt", "angley", "anglepitch", "pitchang", "angpitch",
    ]),
    (Role::HeadingAngle, &[
        "psi", "yaw", "heading", "hdg", "trueheading", "headingtrue", "hdingtrue", "headingangle", "yawangle", "euleryaw",
        "yaweuler", "euleryawangle", "eulerheading", "hdgtrue", "hdgmag", "headingmag", "magheading", "headingmagnetic",
        "magneticheading", "azimuth", "headtrue", "headmag", "anglez", "angleyaw", "yawang", "angyaw", "compass", "hdgt", "hdgm", "thdg", "thdng", "trueheadingangle",
    ]),
    (Role::TrueAirspeed, &[
        "airspeed", "tas", "vtas", "trueairspeed", "vtrue", "vtotal", "vtot", "va", "vt", "v", "ktas", "speedtrue",
        "airspeedtrue", "tasspeed", "vair", "aspd", "arspd", "airspd", "pitotspeed", "speedair", "airvel",
    ]),
    (Role::AngleOfAttack, &["alpha", "aoa", "angleofattack", "alfa", "alphavane", "vaneaoa", "attackangle", "aoal", "aoar", "alf"]),
    (Role::Sideslip, &[
        "beta", "aos", "sideslip", "angleofsideslip", "betavane", "vaneaos", "ssa", "sideslipangle", "slipangle",
        "anglesideslip", "aoss", "bet", "sslip", "flankangle", "lateralflowangle",
    ]),
    (Role::Aileron, AILERON),
    (Role::Elevator, &[
        "deltae", "deltam", "de", "dm", "elevator", "delev", "elev", "elv", "elevatorpos", "elevatordeflection",
        "elevatorposition", "elevpos", "elevatorangle", "elevatorpositionleft", "elevatorpositionright", "elvl", "elvr",
        "elevl", "elevr", "ele",
        "dele", "elevatorteup", "elevatorteu", "elevatortrailingedgeup", "elevatortedown", "elevatorted",
        "elevatortrailingedgedown",
    ]),
    (Role::Rudder, &[
        "deltar", "deltan", "dr", "dn", "rudder", "drud", "rud", "rudderpos", "rudderdeflection", "rudderposition", "rudpos",
        "rudderangle", "rudd", "rdr", "delr",
    ]),
    (Role::ElevatorTrim, &["deltate", "dte", "elevatortrim", "elevtrim", "elevatordte", "trimtab"]),
    (Role::Stabiliser, &["stabiliser", "stabilizer", "stab", "ih", "ths"]),
    (Role::Flap, &["flap", "flaps", "df", "deltaf", "flappos", "flapangle", "dfr", "dfl", "flapposition", "flapc"]),
    (Role::StaticPressure, &[
        "staticpressure", "ps", "pstat", "pstatic", "static", "staticpress", "baro", "ambientpressure", "airpressure",
        "baropressure", "baropress", "barometricpressure", "atmpressure", "pressurestatic", "pressstatic", "pressurebaro", "pressabs", "pressureabs", "abspressure", "absolutepressure", "absolutepress", "barometer", "barompressure",
        "pambient", "pamb", "pressure", "press",
    ]),
    (Role::AirTemperature, &[
        "airtemperature", "sat", "oat", "staticairtemperature", "airtemp", "airtc", "outsideairtemperature",
        "ambienttemperature", "tempambient", "outsideairtemp", "ambienttemp", "tair", "ts", "tamb", "tstatic", "tstat",
        "statictemperature", "statictemp", "satr",
    ]),
    (Role::TotalTemperature, &["totaltemperature", "tat", "tt", "totalairtemperature", "totalairtemp", "temptotal"]),
    (Role::AirDensity, &["rho", "airdensity", "density"]),
    (Role::Mach, &["mach", "ma", "machnumber"]),
    (Role::CalibratedAirspeed, &[
        "cas", "calibratedairspeed", "ias", "vcas", "vias", "kias", "kcas", "indicatedairspeed", "airspeedindicated",
        "computedairspeed", "airspeedcomputed", "airspeedcomp", "airspeedind", "indairspeed", "calairspeed",
        "airspeedcal", "airspeedcalibrated", "indicatedspeed", "speedindicated", "iasspeed",
    ]),
    (Role::EquivalentAirspeed, &[
        "equivalentairspeed", "eas", "keas", "veas", "vequiv", "airspeedequivalent", "equivalentspeed", "speedequivalent",
        "equivairspeed", "airspeedequiv", "eqairspeed",
    ]),
    (Role::ImpactPressure, &[
        "impactpressure", "qc", "qci", "pdyn", "pdynamic", "dynamicpressure", "dynpressure", "dynpress", "differentialpressure",
        "diffpressure", "diffpress", "pressdiff", "dpress", "differentialpress", "pdiff", "pitotpressure", "pitotdiff",
    ]),
    (Role::Altitude, &[
        "altitude", "alt", "pressurealtitude", "hp", "hpc", "palt", "altp", "h", "baroalt", "altitudeasl", "altitudestd", "altstdc", "altstd", "zp",
        "altitudesealevel", "altitudemeansealevel", "altitudeabovesealevel", "altind", "altitudeind", "heightabovesealevel", "hbaro", "altbaro",
        "pressurealt", "pressalt", "altitudepressure", "altitudepress", "altpressure", "altpress", "altitudeqne", "altqne", "altb",
        "altitudebaro", "baroaltitude", "barometricaltitude", "altbarometric", "baroheight", "height", "altitudeabsolute",
        "altitudeamsl", "altamsl", "hasl", "altasl", "fl", "flightlevel",
    ]),
    (Role::Latitude, &["latitudegeodetic", "latitude", "lat", "gpslat", "latgps", "latitudegps", "gpslatitude", "latp", "latpc"]),
    (Role::Longitude, &[
        "longitude", "lon", "long", "lng", "gpslon", "gpslong", "gpslng", "longps", "lnggps", "longgps", "longitudegps",
        "gpslongitude", "lonp", "lonpc",
    ]),
    (Role::GpsAltitude, &[
        "gpsaltitude", "gpsalt", "geoaltitude", "altgps", "hgps", "gpsheight", "altitudemsl", "altmsl", "hmsl", "heightmsl",
        "hsl", "gpsalti", "gnssaltitude", "gnssalt", "hell", "heightellipsoid", "ellipsoidheight", "ellipsoidalheight",
        "altitudewgs84", "altellipsoid", "altitudegps", "gpsheightmsl", "ele",
    ]),
    (Role::FuelMass, &["fuelmass", "fuelonboard", "fuelweight", "fuelquantity", "fuelqty", "fuel"]),
    (Role::FuelFlow, &["fuelflow", "ff"]),
    (Role::Thrust1, &["thrust1", "thrustleft", "thrustfront", "thrust"]),
    (Role::Thrust2, &["thrust2", "thrustright", "thrustrear"]),
    (Role::EngineSpeed1, &[
        "enginespeed1", "rpm1", "n11", "rpm", "rpmleft", "motorrpm", "enginerpm", "enginespeed", "e1rpm", "eng1rpm", "rpml",
        "propellerrpm", "proprpm",
    ]),
    (Role::EngineSpeed2, &["enginespeed2", "rpm2", "rpmright", "e2rpm", "eng2rpm", "rpmr"]),
    (Role::ManifoldPressure1, &["manifoldpressure1", "map1", "mp1", "e1map", "manifoldpressure", "manifoldpress"]),
    (Role::ManifoldPressure2, &["manifoldpressure2", "map2", "mp2"]),
    (Role::Power1, &["power1", "power"]),
    (Role::Power2, &["power2"]),
    (Role::WeightOnWheels, &[
        "weightonwheels", "wow", "squatswitch", "onground", "weightonwheel", "onrunwy", "onrunway",
    ]),
];

/// Whether small letters without separators are a name of a role.
pub(crate) fn is_known(plain: &str) -> bool {
    NAMES.iter().any(|(_, names)| names.contains(&plain))
}

/// Names of ailerons: their common deflection first, then the right one, whose trailing edge down is positive, then the left one, turned.
pub(crate) const AILERON: &[&str] = &[
    "deltaa", "deltal", "da", "dl", "aileron", "dail", "dela", "ail", "ailerondeflection", "rightaileron",
    "aileronright", "rightail", "ailright", "rightaileronpos", "ailr", "dar", "deltaar", "leftaileron", "aileronleft",
    "leftail", "ailleft", "leftaileronpos", "aill", "dal", "deltaal", "aileronpositionright", "aileronr", "raileron",
    "aileronrh", "aileronpositionleft", "aileronl", "laileron", "aileronlh", "aileronpos", "aileronposition", "ailpos",
    "aileronangle",
];
