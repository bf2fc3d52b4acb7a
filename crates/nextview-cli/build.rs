//! Passes on what only a build script is told: the target and the profile, for `--version`.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    for name in ["TARGET", "PROFILE"] {
        let value = std::env::var(name).expect("set by cargo");
        println!("cargo::rustc-env=NEXTVIEW_{name}={value}");
    }
}
