use nextview_scan::Fault;
use subtle::ConstantTimeEq;

/// A secret that identifies a client.
pub(crate) struct Token(String);

/// Minimum number of characters of a chosen token.
const LEAST: usize = 16;

impl Token {
    /// Generates 256 random bits.
    pub fn random() -> Result<Self, Fault> {
        Ok(Self(random_hex(32)?))
    }

    /// Checks a chosen token: at least 16 visible ASCII characters, without surrounding white space.
    pub fn chosen(text: &str) -> Result<Self, Fault> {
        let text = text.trim();
        if text.len() < LEAST || !text.bytes().all(|byte| byte.is_ascii_graphic()) {
            let message = format!("the token must have at least {LEAST} visible ASCII characters");
            return Err(
                Fault::request(message).with_remedy("make one, for example with `openssl rand -hex 32`")
            );
        }
        Ok(Self(text.to_owned()))
    }

    /// Compares in a time that does not depend on the number of matching bytes.
    pub fn is(&self, other: &[u8]) -> bool {
        self.0.as_bytes().ct_eq(other).into()
    }

    /// The secret, for its owner only.
    pub fn reveal(&self) -> &str {
        &self.0
    }
}

/// Generates this number of random bytes, as hexadecimal digits.
pub(crate) fn random_hex(n_bytes: usize) -> Result<String, Fault> {
    let mut bytes = vec![0; n_bytes];
    getrandom::fill(&mut bytes)
        .map_err(|error| Fault::data(format!("the system has no random numbers: {error}")))?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}
