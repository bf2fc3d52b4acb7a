//! Passes on the target and the profile, which only a build script knows, for `--version`.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    for name in ["TARGET", "PROFILE"] {
        let value = std::env::var(name).expect("set by cargo");
        println!("cargo::rustc-env=NEXTVIEW_{name}={value}");
    }
}
