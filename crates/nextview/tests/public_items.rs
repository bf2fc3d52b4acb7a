//! The interface is listed in `public-items.txt`.

#[test]
fn public_items_are_listed() {
    nextview_checks::check_public_items(env!("CARGO_MANIFEST_DIR"), env!("CARGO_PKG_NAME"));
}
