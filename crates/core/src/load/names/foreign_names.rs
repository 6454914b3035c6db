//! German, French, Spanish, Portuguese, Italian and Dutch names of channels, and what some of them need beside them to have one reading.

use crate::load::names::role_names::{RoleNames, is_known};
use crate::load::names::stated_unit::stem_and_unit;
use crate::load::names::words::{join_words, plain_letters};
use crate::quantity::Role;

/// Names a role goes by in other languages than English as [`crate::load::names::words::join_words`] writes them, best first.
#[rustfmt::skip]
pub(crate) const FOREIGN_NAMES: &[RoleNames] = &[
    (Role::SpecificForceX, &[
        "beschlx", "beschleunigungx", "xbeschleunigung", "beschllangs", "beschllaengs", "beschleunigunglangs",
        "beschleunigunglaengs", "langsbeschl", "laengsbeschl", "langsbeschleunigung", "laengsbeschleunigung",
        "accelerationx", "accelerationlongitudinale", "accellongitudinale", "acclongitudinale", "facteurchargenx",
        "facteurchargex", "facteurchargelongitudinal", "aceleracionx", "aceleracionlongitudinal", "aceleracaox",
        "aceleracaolongitudinal", "accelerazionex", "accelerazionelongitudinale", "versnellingx", "versnellinglangs",
        "langsversnelling",
    ]),
    (Role::SpecificForceY, &[
        "beschly", "beschleunigungy", "ybeschleunigung", "beschlquer", "beschleunigungquer", "querbeschl",
        "querbeschleunigung", "seitenbeschleunigung", "accelerationy", "accelerationlaterale", "accellaterale",
        "acclaterale", "facteurchargeny", "facteurchargey", "facteurchargelateral", "aceleraciony", "aceleracionlateral", "aceleracaoy",
        "aceleracaolateral", "accelerazioney", "accelerazionelaterale", "versnellingy", "versnellingdwars",
        "dwarsversnelling",
    ]),
    (Role::SpecificForceZ, &[
        "beschlz", "beschleunigungz", "zbeschleunigung", "beschlhoch", "beschleunigunghoch", "beschlvertikal",
        "vertikalbeschl", "vertikalbeschleunigung", "beschlnormal", "normalbeschl", "normalbeschleunigung",
        "lastvielfaches", "accelerationz", "accelerationverticale", "accelverticale", "accverticale",
        "accelerationnormale", "accelnormale", "accnormale", "facteurchargenz", "facteurchargez", "facteurchargenormal",
        "facteurchargevertical", "facteurcharge", "factorcargavertical", "factorcarganormal", "factorcarga",
        "fattoredicaricoverticale", "fattoredicariconormale", "fattoredicarico", "fatordecarga", "fatorcarga", "aceleracionz", "aceleracionvertical", "aceleracaoz", "aceleracaovertical",
        "aceleracaonormal", "accelerazionez", "accelerazioneverticale", "accelerazionenormale", "versnellingz",
        "versnellingverticaal", "verticaleversnelling", "normaalversnelling",
    ]),
    (Role::RollRate, &[
        "velocidadalabeo", "滚转角速度", "滚转速率", "rollrate", "drehratex", "drehrateroll", "rolldrehrate", "rollgeschw",
        "rollgeschwindigkeit", "rollwinkelgeschwindigkeit", "winkelgeschwindigkeitx", "kreiselx", "vitesseroulis",
        "tauxroulis", "vitesseangulaireroulis", "vitesserotationroulis", "vitesseangulairex", "roulis", "rollen",
        "razaorolamento", "taxarolamento", "velocidaderolamento", "velocitarollio", "velocitadirollio", "rolsnelheid",
    ]),
    (Role::PitchRate, &[
        "velocidadcabeceo", "俯仰角速度", "俯仰速率", "nickrate", "drehratey", "drehratenick", "nickdrehrate", "nickgeschw",
        "nickgeschwindigkeit", "nickwinkelgeschwindigkeit", "winkelgeschwindigkeity", "kreisely", "vitessetangage",
        "tauxtangage", "vitesseangulairetangage", "vitesserotationtangage", "vitesseangulairey", "tangage", "nicken",
        "razaoarfagem", "taxaarfagem", "velocidadearfagem", "velocitabeccheggio", "velocitadibeccheggio",
        "stampsnelheid",
    ]),
    (Role::YawRate, &[
        "velocidadguinada", "偏航角速度", "偏航速率", "gierrate", "drehratez", "drehrategier", "gierdrehrate", "giergeschw",
        "giergeschwindigkeit", "gierwinkelgeschwindigkeit", "winkelgeschwindigkeitz", "kreiselz", "vitesselacet",
        "tauxlacet", "vitesseangulairelacet", "vitesserotationlacet", "vitesseangulairez", "lacet", "gieren",
        "razaoguinada", "taxaguinada", "velocidadeguinada", "velocitaimbardata", "velocitadiimbardata", "giersnelheid",
    ]),
    (Role::VelocityNorth, &[
        "vnord", "vnorte", "vnoord", "geschwnord", "geschwindigkeitnord", "nordgeschwindigkeit", "vitessenord", "velocidadnorte",
        "velocidadenorte", "velocitanord", "snelheidnoord", "noordsnelheid",
    ]),
    (Role::VelocityEast, &[
        "vost", "vest", "veste", "vleste", "voost", "geschwost", "geschwindigkeitost", "ostgeschwindigkeit", "vitesseest", "velocidadeste",
        "velocidadeleste", "velocitaest", "snelheidoost", "oostsnelheid",
    ]),
    (Role::VelocityDown, &[
        "vunten", "vbas", "vabajo", "vbaixo", "vgiu", "vomlaag", "vitessebas", "velocidadvertical", "velocidadabajo", "velocitaverticale", "вертикальнаяскорость", "升降速度", "垂直速度", "爬升率",
        "vario", "variometer", "variometre", "steigrate", "steiggeschw", "steiggeschwindigkeit", "vertikalgeschw",
        "vertikalgeschwindigkeit", "vitesseverticale", "vitesseascensionnelle", "tauxmontee", "sinkrate", "sinkgeschw",
        "sinkgeschwindigkeit", "vz", "geschwunten", "geschwindigkeitunten", "velocidadeparabaixo", "velocitagiu", "snelheidomlaag",
    ]),
    (Role::BankAngle, &[
        "yatis", "yatisacisi", "φ",
        "alabeo", "anguloalabeo", "rollio", "angolorollio", "rolamento", "angulorolamento", "крен", "уголкрена", "滚转角",
        "横滚角", "滚转", "横滚", "rollwinkel", "hangewinkel", "haengewinkel", "querlage", "querneigung", "querneigungswinkel",
        "schraglage", "schraeglage", "gite", "anglegite", "angleroulis", "assiettelaterale", "inclinaisonlaterale",
        "roulis", "rollen", "angolodirollio", "rolhoek",
    ]),
    (Role::PitchAngle, &[
        "yunuslama", "dikilme", "yunuslamaacisi", "θ",
        "cabeceo", "angulocabeceo", "beccheggio", "arfagem", "тангаж", "уголтангажа", "俯仰角", "俯仰", "nickwinkel",
        "langsneigung", "laengsneigung", "langsneigungswinkel", "laengsneigungswinkel", "assiette",
        "assiettelongitudinale", "angleassiette", "angletangage", "tangage", "nicken", "anguloarfagem",
        "angolobeccheggio", "angolodibeccheggio", "langslagewinkel", "laengslagewinkel", "langshelling", "stamphoek",
    ]),
    (Role::HeadingAngle, &[
        "yonelme", "sapma", "yonelmeacisi", "ψ",
        "guinada", "rumbo", "rumboverdadero", "angoloprua", "angolodiprua", "pruavera", "azimut", "imbardata", "prua", "proa", "курс", "рыскание", "偏航角", "航向角", "偏航", "航向", "gierwinkel",
        "steuerkurs", "steuerkurswahr", "kurs", "cap", "capvrai", "capgeographique", "anglecap", "anglelacet",
        "capmagnetique", "lacet", "gieren", "angulodeguinada", "anguloguinada", "angoloimbardata", "angolodiimbardata",
        "koers", "gierhoek",
    ]),
    (Role::TrueAirspeed, &[
        "velocidadaire", "velocidadaerodinamica", "velocidadverdadera", "воздушнаяскорость", "真空速", "空速",
        "fluggeschwwahr", "fluggeschwindigkeitwahr", "wahrefluggeschw", "wahrefluggeschwindigkeit",
        "wahreeigengeschwindigkeit", "eigengeschwindigkeitwahr", "taswahr", "vwahr", "vitessevraie", "vitesseairvraie",
        "vitessepropre", "vv", "eigengeschwindigkeit", "fluggeschw", "fluggeschwindigkeit", "vitesseair", "vp",
        "velocidadeverdadeira", "velocitavera", "wareluchtsnelheid", "waresnelheid",
    ]),
    (Role::AngleOfAttack, &[
        "anguloataque", "уголатаки", "迎角", "攻角", "anstellwinkel", "anstellw", "incidence", "angleincidence",
        "angleattaque", "angoloattacco", "angolodiattacco", "invalshoek",
    ]),
    (Role::Sideslip, &[
        "derrape", "deslizamiento", "resbalamiento", "anguloresbalamiento", "уголскольжения", "侧滑角", "schiebewinkel",
        "schiebew", "derapage", "anglederapage", "derrapagem", "anguloderrapagem", "derapata", "angoloderapata",
        "angolodiderapata", "sliphoek",
    ]),
    (Role::Aileron, FOREIGN_AILERON),
    (Role::Elevator, &[
        "timonprofundidad", "elevador", "profundor", "рульвысоты", "升降舵", "hohenruder", "hoehenruder",
        "hohenruderausschlag", "hoehenruderausschlag", "hohenruderwinkel", "hoehenruderwinkel", "hohenruderstellung",
        "hoehenruderstellung", "profondeur", "gouverneprofondeur", "hohenrudereta", "hoehenrudereta", "braquageprofondeur", "braquagegouverneprofondeur",
        "eta", "equilibratore", "hoogteroer",
    ]),
    (Role::Rudder, &[
        "timondireccion", "leme", "timone", "рульнаправления", "方向舵", "seitenruder", "seitenruderausschlag",
        "seitenruderwinkel", "seitenruderstellung", "seitenruderzeta", "gouvernedirection", "braquagedirection",
        "braquagegouvernedirection", "direction", "palonnier", "zeta", "lemedirecao", "timonedidirezione",
        "richtingsroer",
    ]),
    (Role::ElevatorTrim, &[
        "hohenrudertrimmung", "hoehenrudertrimmung", "hohenrudertrimm", "hoehenrudertrimm", "trimmruder",
        "compensateurprofondeur", "tabprofondeur",
    ]),
    (Role::Stabiliser, &["hohenflosse", "hoehenflosse"]),
    (Role::Flap, &[
        "klappen", "landeklappen", "klappenstellung", "klappenwinkel", "wolbklappen", "woelbklappen", "volets",
        "braquagevolets",
    ]),
    (Role::StaticPressure, &["statischerdruck", "statikdruck", "druckstatisch", "luftdruck", "pressionstatique"]),
    (Role::AirTemperature, &[
        "aussentemperatur", "lufttemperatur", "statischetemperatur", "temperaturestatique", "temperatureexterieure",
        "temperatureair", "temperaturaexterior", "temperature", "temperaturaexterna", "temperaturaesterna",
        "buitentemperatuur",
    ]),
    (Role::TotalTemperature, &["gesamttemperatur", "totaltemperatur", "temperaturetotale"]),
    (Role::AirDensity, &["luftdichte", "densiteair", "massevolumique", "massevolumiqueair"]),
    (Role::Mach, &["machzahl", "nombremach"]),
    (Role::CalibratedAirspeed, &[
        "velocidadindicada", "velocitaindicata", "velocidadeindicada", "приборнаяскорость", "表速", "指示空速",
        "iasangezeigt", "angezeigtefluggeschw", "angezeigtefluggeschwindigkeit", "fluggeschwangezeigt",
        "fluggeschwindigkeitangezeigt", "vangezeigt", "vitesseindiquee", "vitesseairindiquee", "vitesseconventionnelle",
        "vc", "aangewezensnelheid",
    ]),
    (Role::Altitude, &[
        "irtifa", "yukseklik",
        "altitud", "altitudpresion", "altitudbarometrica", "altura", "quota", "quotabarometrica", "quotapressione", "altezza", "altitudepressao", "высота", "气压高度", "高度", "hohe", "hoehe",
        "druckhohe", "druckhoehe", "hohemsl", "hoehemsl", "flughohe", "flughoehe", "barohohe", "barohoehe",
        "barometrischehohe", "barometrischehoehe", "altitudepression", "altitudebaro", "altitudebarometrique", "baro",
        "altitudine", "hoogte", "drukhoogte",
    ]),
    (Role::Latitude, &["latitud", "enlem", "latitudine", "широта", "纬度", "breitengrad", "breite", "breedtegraad"]),
    (Role::Longitude, &[
        "boylam",
        "longitud", "longitudine", "долгота", "经度", "langengrad", "laengengrad", "lange", "laenge", "lengtegraad",
    ]),
    (Role::GpsAltitude, &["gpshohe", "gpshoehe", "hohegps", "hoehegps", "altitudegps"]),
    (Role::FuelMass, &[
        "kraftstoff", "kraftstoffmasse", "treibstoff", "treibstoffmasse", "carburant", "massecarburant",
    ]),
    (Role::FuelFlow, &["kraftstoffdurchfluss", "kraftstoffverbrauch", "debitcarburant", "consommationcarburant"]),
    (Role::Thrust1, &["schub", "schub1", "poussee", "poussee1"]),
    (Role::Thrust2, &["schub2", "poussee2"]),
    (Role::EngineSpeed1, &["drehzahl", "motordrehzahl", "drehzahl1", "regime", "regimemoteur", "regime1"]),
    (Role::EngineSpeed2, &["drehzahl2", "motordrehzahl2", "regime2", "regimemoteur2"]),
    (Role::ManifoldPressure1, &["ladedruck", "ladedruck1", "pressionadmission", "pressionadmission1"]),
    (Role::ManifoldPressure2, &["ladedruck2", "pressionadmission2"]),
    (Role::Power1, &["leistung", "motorleistung", "puissance", "puissancemoteur"]),
];

/// Names of ailerons in the order of [`crate::load::names::role_names::AILERON`].
#[rustfmt::skip]
pub(crate) const FOREIGN_AILERON: &[&str] = &[
    "querruder", "aleron", "alerones", "alettoni", "alettone", "rolroer", "элероны", "副翼", "querruderausschlag",
    "querruderwinkel", "querruderstellung", "ailerons", "braquageailerons", "gauchissement",
    "braquagegauchissement", "xi", "querruderxi", "querruderrechts", "rechtesquerruder", "alettonedestro", "ailerondroit", "braquageailerondroit",
    "querruderlinks", "linkesquerruder", "alettonesinistro", "ailerongauche", "braquageailerongauche",
];

/// Airspeeds that do not say whether they are true or indicated.
pub(crate) const AIRSPEEDS_OF_NO_KIND: [&str; 4] =
    ["eigengeschwindigkeit", "fluggeschw", "fluggeschwindigkeit", "vitesseair"];

/// What a name needs to have one reading.
#[derive(Clone, Copy)]
pub(crate) enum Need {
    /// A unit that the role has.
    Unit,
    /// The same; or, to be an angle, that the rate about its axis is another channel.
    UnitOrRate(Role),
    /// One of these units.
    OneOf(&'static [&'static str]),
    /// Another channel with a French name of a control.
    FrenchControl,
    /// All of these names: the controls by their letters of LN 9300 or of French tests.
    AllOf(&'static [&'static str]),
    /// A unit that the role has, or without one another channel of one of these names, unless it is this role.
    UnitUnless(Role, &'static [&'static str]),
    /// An accent: without one the word is English too, and the temperature that of any sensor.
    Accent,
    /// A unit that the role has, or another channel of one of these names.
    UnitOrBeside(&'static [&'static str]),
    /// All of the names beside it that a role needs.
    ByRole(&'static [(Role, &'static [&'static str])]),
}

/// Names that have more than one reading by themselves.
pub(crate) const NEEDS: &[(&str, Need)] = &[
    ("long", Need::UnitUnless(Role::Longitude, &["latg", "vrtg"])),
    ("roulis", Need::UnitOrRate(Role::RollRate)),
    ("rollen", Need::UnitOrRate(Role::RollRate)),
    ("tangage", Need::UnitOrRate(Role::PitchRate)),
    ("nicken", Need::UnitOrRate(Role::PitchRate)),
    ("lacet", Need::UnitOrRate(Role::YawRate)),
    ("gieren", Need::UnitOrRate(Role::YawRate)),
    ("kraftstoff", Need::Unit),
    ("treibstoff", Need::Unit),
    ("carburant", Need::Unit),
    ("kraftstoffdurchfluss", Need::Unit),
    ("kraftstoffverbrauch", Need::Unit),
    ("debitcarburant", Need::Unit),
    ("consommationcarburant", Need::Unit),
    ("leistung", Need::Unit),
    ("puissance", Need::Unit),
    ("palonnier", Need::Unit),
    // Down in the conventions, up on every instrument that shows feet per minute.
    ("vz", Need::OneOf(&["ft/min"])),
    // Without a unit: an angle of the stick, a level, a course, the bow or rudder of a ship.
    ("rolamento", Need::UnitOrRate(Role::RollRate)),
    ("arfagem", Need::UnitOrRate(Role::PitchRate)),
    ("rollio", Need::UnitOrRate(Role::RollRate)),
    ("beccheggio", Need::UnitOrRate(Role::PitchRate)),
    ("quota", Need::Unit),
    ("koers", Need::Unit),
    ("proa", Need::Unit),
    ("prua", Need::Unit),
    ("leme", Need::Unit),
    ("timone", Need::Unit),
    // Vitesse vraie or vitesse verticale.
    ("vv", Need::OneOf(&["kt", "km/h"])),
    ("direction", Need::FrenchControl),
    // Vitesse conventionnelle, vitesse propre.
    ("vc", Need::OneOf(&["kt", "km/h"])),
    ("vp", Need::OneOf(&["kt", "km/h"])),
    // A pressure, unless it is in feet or metres.
    ("baro", Need::UnitUnless(Role::StaticPressure, &[])),
    ("temperature", Need::Accent),
    ("xi", Need::AllOf(&GREEK_CONTROLS)),
    ("eta", Need::AllOf(&GREEK_CONTROLS)),
    ("zeta", Need::AllOf(&GREEK_CONTROLS)),
    ("dl", Need::AllOf(&DELTA_CONTROLS)),
    ("dm", Need::AllOf(&DELTA_CONTROLS)),
    ("dn", Need::AllOf(&DELTA_CONTROLS)),
    // In g it is the load factor.
    ("load", Need::Unit),
    // Elevator beside the other controls, elevation beside fixes.
    ("ele", Need::ByRole(&[(Role::Elevator, &["ail", "rud"]), (Role::GpsAltitude, &["lat", "lon"])])),
    // Width and length of anything.
    ("breite", Need::UnitOrBeside(&["lange", "laenge"])),
    ("lange", Need::UnitOrBeside(&["breite"])),
    ("laenge", Need::UnitOrBeside(&["breite"])),
];

/// French names of controls that are nothing else.
pub(crate) const FRENCH_CONTROLS: [&str; 2] = ["profondeur", "gauchissement"];

/// Aileron, elevator and rudder after the moments L, M, N that they make.
const DELTA_CONTROLS: [&str; 3] = ["dl", "dm", "dn"];

/// Aileron, elevator and rudder in LN 9300.
const GREEK_CONTROLS: [&str; 3] = ["xi", "eta", "zeta"];

/// Whether a channel of this name is made for a role.
pub(crate) fn is_role_name(name: &str) -> bool {
    let (stem, _) = stem_and_unit(name);
    let (plain, words) = (plain_letters(stem), join_words(stem));
    is_known(&plain) || FOREIGN_NAMES.iter().any(|(_, names)| names.contains(&words.as_str()))
}

/// Letters of the shortest name that may stand at the end of a longer one.
const LEAST_ENDING: usize = 7;
/// Words before a name that make another quantity of it: a rate, a force, a trim tab, the wind.
const OTHER_QUANTITIES: [&str; 16] = [
    "angul", "winkel", "dreh", "vitesse", "velocidad", "taux", "trim", "compens", "tab", "kraft", "effort", "moment",
    "servo", "wind", "vent", "viento",
];

/// Whether a channel's name ends on `name`, behind words that leave it what it is: `imurollrate`.
pub(crate) fn ends_on(words: &str, name: &str) -> bool {
    let before = words.strip_suffix(name).filter(|_| name.len() >= LEAST_ENDING);
    let has_need = NEEDS.iter().any(|(known, _)| *known == name);
    before.is_some_and(|before| !has_need && !OTHER_QUANTITIES.iter().any(|other| before.contains(other)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_that_join_words_writes() {
        for (role, names) in FOREIGN_NAMES {
            for name in *names {
                assert_eq!(join_words(name), *name, "{}", role.name());
            }
        }
        for (name, _) in NEEDS {
            assert!(is_known(name) || FOREIGN_NAMES.iter().any(|(_, names)| names.contains(name)), "{name}");
        }
    }

    #[test]
    fn a_name_may_stand_behind_where_it_was_measured_and_not_behind_what_makes_it_another_quantity() {
        assert!(ends_on("imurollrate", "rollrate") && ends_on("ahrsnickwinkel", "nickwinkel"));
        assert!(!ends_on("winkelbeschleunigungx", "beschleunigungx") && !ends_on("effortprofondeur", "profondeur"));
        assert!(!ends_on("radarhohe", "hohe") && !ends_on("roulis", "roulis"));
    }
}
