//! Formulas of the manual as they are shown: letters that every screen has, no TeX.

use doublet_cli::formula::{readable, readable_page};
use doublet_cli::manual;

#[test]
fn formulas_become_one_line_of_letters() {
    for (tex, shown) in [
        (r"\hat\theta = (X^T X)^{-1} X^T z", "θ\u{302} = (Xᵀ X)⁻¹ Xᵀ z"),
        (r"C_X = \frac{m\,a_x}{\bar q S}", "CX = (m aₓ)/(q\u{304} S)"),
        (r"\beta = \arctan\frac{v}{\sqrt{u^2+w^2}}", "β = arctan v/√(u²+w²)"),
        (r"s^2 = \frac{v^T v}{n-p}", "s² = (vᵀ v)/(n\u{2212}p)"),
        (r"\dot u = a_x - b_{ax} - g\sin\theta", "u\u{307} = aₓ \u{2212} bₐₓ \u{2212} g sin θ"),
        (r"D \Bigl[\sum_i R_{vv}(i-j)\Bigr] D", "D [Σᵢ Rᵥᵥ(i\u{2212}j)] D"),
        (r"x_s^+ - x^-", "xₛ⁺ \u{2212} x⁻"),
        (r"M = I\dot\omega + \omega\times I\omega", "M = Iω\u{307} + ω × Iω"),
    ] {
        assert_eq!(readable(tex), shown, "{tex}");
    }
}

#[test]
fn formula_cut_off_ends_without_a_panic() {
    for tex in ["\\", "\\frac{a", "x^", "x_{", "\\sqrt", "\\hat", "{{{", "\\unknown"] {
        assert!(!readable(tex).contains('\\'), "{tex}");
    }
    assert_eq!(readable_page("a \\\\( x_1 and more"), "a x₁ and more");
}

#[test]
fn no_page_that_is_shown_has_tex_in_it() {
    let pages = manual::pages();
    assert!(pages.len() > 25);
    let mut formulas = 0;
    for page in pages {
        let text = page.whole();
        let left: Vec<&str> = text.lines().filter(|line| line.contains('\\')).collect();
        assert!(left.is_empty(), "{}: {left:#?}", page.path);
        formulas += text.matches(['ₓ', 'θ', '⁻']).count();
    }
    assert!(formulas >= 15, "formulas were seen: {formulas}");
}
